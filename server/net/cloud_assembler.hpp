#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "common/result.hpp"
#include "common/wire/limits.hpp"

namespace headframe {

/// Puts the chunks of clouds together. A requested cloud may overtake one that is on its way in the background, so a
/// few are open at a time; memory grows with the bytes that came, never with the size that was announced, up to
/// open_bytes. Not thread safe.
class CloudAssembler {
 public:
  static constexpr std::size_t open_clouds = 4;
  static constexpr std::size_t open_bytes = 2 * limits::cloud_bytes;

  /// The whole cloud when this chunk was its last. bad_input: sizes that do not fit together, or too many open clouds.
  /// A chunk at offset 0 starts its cloud anew.
  Result<std::optional<std::string>> add(std::uint64_t sequence, std::size_t total_bytes, std::size_t offset,
                                         const std::string& data);

  /// What came of this cloud, if anything.
  void forget(std::uint64_t sequence);

 private:
  struct Open {
    std::size_t total_bytes = 0;
    std::string bytes;
  };
  std::map<std::uint64_t, Open> open_;
  std::size_t bytes_ = 0;  // of all that are open
};

}  // namespace headframe
