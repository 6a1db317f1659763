#include "server/merge/submap_cache.hpp"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "tests/support/drawn_session.hpp"

namespace headframe {
namespace {

struct Shelf : CloudSource {
  std::map<KeyframeRef, KeyframeCloud> clouds;
  CloudState state(const KeyframeRef& k) const override {
    return clouds.contains(k) ? CloudState::stored : CloudState::obtainable;
  }
  Result<CloudDecoder> load(const KeyframeRef& k) override {
    loaded.insert(k);
    return [this, k]() -> Result<KeyframeCloud> {
      if (damaged.contains(k)) return failure(ErrorCode::bad_input, "damaged");
      return clouds.at(k);
    };
  }
  std::set<KeyframeRef> loaded, damaged;
};

/// A drive of keyframes 2 m apart, its clouds on the shelf.
struct SubmapCacheTest : testing::Test {
  test::Drive drive = test::drive_a_to_c(2);
  std::vector<double> path_to_m;
  Shelf shelf;
  CloudCache prepared{100000000, 1};

  SubmapCacheTest() {
    for (std::size_t i = 0; i < drive.keyframes.size(); ++i) {
      path_to_m.push_back(2.0 * static_cast<double>(i));
      drive.keyframes[i].point_count = 1;
      shelf.clouds[{1, drive.keyframes[i].sequence}] = drive.clouds[i];
    }
  }
  SubmapCache book(std::size_t capacity_bytes = 100000000, int threads = 1) {
    return {capacity_bytes, threads, SubmapConfig{}, prepared};
  }
  SubmapRequest at(std::size_t keyframe) const { return {1, drive.keyframes, path_to_m, keyframe}; }
  SubmapPtr one(SubmapCache& from, std::size_t keyframe) {
    const SubmapRequest request = at(keyframe);
    return from.get({&request, 1}, shelf).front();
  }
};

TEST_F(SubmapCacheTest, KeyframesOfTheSameThreeMetresShareAPlace) {
  SubmapCache b = book();
  EXPECT_EQ(one(b, 0), one(b, 1)) << "0 and 2 m";
  EXPECT_NE(one(b, 1), one(b, 2)) << "2 and 4 m";
  EXPECT_EQ(one(b, 2)->p, drive.keyframes[2].T_local_sensor.translation());
  EXPECT_GT(one(b, 2)->source.points.size(), 1000U);
}

TEST_F(SubmapCacheTest, ManyAtOnceAreThoseOneByOneWhateverTheThreads) {
  SubmapCache alone = book(), many = book(100000000, 3);
  const std::vector<SubmapRequest> requests{at(4), at(0), at(4), at(8)};
  const auto places = many.get(requests, shelf);
  EXPECT_EQ(places[0], places[2]);
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const SubmapPtr same = one(alone, requests[i].keyframe);
    EXPECT_EQ(places[i]->source.points, same->source.points);
    EXPECT_EQ(places[i]->rock.points, same->rock.points);
  }
}

TEST_F(SubmapCacheTest, ACloudThatComesLaterIsTakenIn) {
  const KeyframeRef late{1, drive.keyframes[3].sequence};
  const auto held = shelf.clouds.extract(late);
  SubmapCache b = book();
  const SubmapPtr before = one(b, 2);
  EXPECT_EQ(before, one(b, 2));
  shelf.clouds[late] = held.mapped();
  const SubmapPtr after = one(b, 2);
  EXPECT_NE(before, after);
  EXPECT_EQ(after->views.size(), before->views.size() + 1);
}

TEST_F(SubmapCacheTest, WhatTheRobotSawByAnotherTimeOfItsPathIsNotMixedIn) {
  for (std::size_t i = 10; i < path_to_m.size(); ++i) path_to_m[i] += 1000;  // it came by again much later
  SubmapCache b = book();
  EXPECT_EQ(one(b, 8)->views.size(), 10U);
}

TEST_F(SubmapCacheTest, TheLeastRecentlyUsedGoes) {
  SubmapCache whole = book();
  std::set<const SightImage*> images;
  std::size_t bytes = 0;  // of the first, the second and the third place, and of what they look from
  for (const std::size_t keyframe : {0, 4, 8}) {
    const SubmapPtr place = one(whole, keyframe);
    bytes += bytes_of(*place);
    for (const PlacedView& view : place->views)
      if (images.insert(view.image.get()).second) bytes += view.image->bytes();
  }
  for (const bool fits : {true, false}) {
    SubmapCache b = book(fits ? bytes : bytes - 1);
    const SubmapPtr first = one(b, 0), second = one(b, 4);
    EXPECT_EQ(first, one(b, 0));
    one(b, 8);
    EXPECT_EQ(first, one(b, 0));
    EXPECT_EQ(second == one(b, 4), fits);
  }
}

TEST_F(SubmapCacheTest, OneThatIsLargerThanAllRoomIsKeptUntilTheNext) {
  SubmapCache b = book(1);
  const SubmapPtr first = one(b, 0);
  EXPECT_EQ(first, one(b, 0));
  one(b, 8);
  EXPECT_NE(first, one(b, 0));
}

TEST_F(SubmapCacheTest, PreparedCloudsGoWhenTheyDoNotFit) {
  const KeyframeRef one{1, 1}, two{1, 2};
  const std::size_t both = bytes_of(*prepared.get(one, shelf)) + bytes_of(*prepared.get(two, shelf));
  EXPECT_GT(both, 2 * sizeof(Eigen::Vector3f) * prepared.get(one, shelf)->points.size());
  for (const bool fits : {true, false}) {
    CloudCache clouds(fits ? both : both - 1, 1);
    const auto first = clouds.get(one, shelf);
    clouds.get(two, shelf);
    EXPECT_EQ(clouds.get(one, shelf) == first, fits);
  }
}

TEST_F(SubmapCacheTest, CloudsFromFarOffAreNotRead) {
  SubmapCache b = book();
  one(b, 0);
  const SubmapConfig config;
  for (std::size_t i = 0; i < drive.keyframes.size(); ++i) {
    const auto p = [&](std::size_t k) { return drive.keyframes[k].T_local_sensor.translation(); };
    const bool near = path_to_m[i] <= config.window_m && (p(i) - p(0)).norm() <= config.farthest_m;
    EXPECT_EQ(shelf.loaded.contains({1, drive.keyframes[i].sequence}), near) << path_to_m[i] << " m along the path";
  }
  EXPECT_LT(shelf.loaded.size(), drive.keyframes.size());
}

TEST_F(SubmapCacheTest, ADamagedCloudIsLeftOut) {
  shelf.damaged.insert({1, 2});
  const std::vector<KeyframeRef> asked{{1, 1}, {1, 2}, {1, 3}};
  for (int again = 0; again < 2; ++again) {
    const auto clouds = prepared.get(asked, shelf);
    EXPECT_TRUE(clouds[0] && !clouds[1] && clouds[2]);
  }
}

TEST_F(SubmapCacheTest, WithoutCloudsAPlaceKnowsNothing) {
  shelf.clouds.clear();
  SubmapCache b = book();
  EXPECT_TRUE(one(b, 0)->source.points.empty());
}

}  // namespace
}  // namespace headframe
