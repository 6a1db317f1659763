#pragma once
// A store in a folder of its own, written to and read from without callbacks.

#include <gtest/gtest.h>

#include <future>

#include "server/store/sqlite_store.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {

inline Result<void> write_and_wait(Store& store, Write write) {
  std::promise<Result<void>> durable;
  store.write(std::move(write), [&](const Result<void>& result) { durable.set_value(result); });
  return durable.get_future().get();
}

inline std::unique_ptr<Store> open(const TempDir& dir, const StoreOptions& options = {}) {
  auto store = open_sqlite_store(dir.path(), options);
  EXPECT_TRUE(store) << (store ? "" : store.error().message);
  return store ? std::move(*store) : nullptr;
}

inline std::vector<Keyframe> keyframes(Store& store, SessionId session, std::uint64_t first = 1) {
  std::vector<Keyframe> all;
  EXPECT_TRUE(store.each_keyframe(session, first, [&](Keyframe k) { all.push_back(std::move(k)); }));
  return all;
}

}  // namespace headframe
