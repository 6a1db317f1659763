// Networks that are good, and files that are not. tests/data/networks/make.py says what each network computes.

#include "common/descriptor/network.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <numeric>
#include <random>
#include <thread>

#include "common/descriptor/family.hpp"
#include "common/descriptor/network_family.hpp"
#include "common/descriptor/open_sky.hpp"
#include "tests/support/box_mine.hpp"
#include "tests/support/temp_dir.hpp"

namespace headframe {
namespace {

using test::BoxMine;
constexpr double degree = std::numbers::pi / 180;

std::filesystem::path network(const std::string& name) {
  return std::filesystem::path(HEADFRAME_SOURCE_DIR) / "tests/data/networks" / (name + ".onnx");
}

Result<Network> load(const std::string& name) {
  return Network::from_bytes(Network::read(network(name)).value(), name);
}

Points crossing_scan(double yaw_rad, double height_m = 3) {
  const BoxMine mine({BoxMine::drift(-30, 0, 30, 0, 4, height_m), BoxMine::drift(0, 0, 0, 30, 4, height_m)});
  std::mt19937 rng(1);
  return mine.scan(pose_from_yaw(yaw_rad, {1, 0.3, 1.2}), rng, 0.01, 32, 720);
}

TEST(Network, SaysWhatItTakesAndGives) {
  const auto plain = load("plain");
  ASSERT_TRUE(plain) << plain.error().message;
  EXPECT_EQ(plain->input(), (Network::Shape{1, 8, 64}));
  ASSERT_EQ(plain->outputs().size(), 3U);
  EXPECT_EQ(plain->outputs()[0].name, "q");
  EXPECT_EQ(plain->outputs()[0].size, 8U);
  EXPECT_EQ(plain->outputs()[1].name, "w");
  EXPECT_EQ(plain->outputs()[1].size, 64U);
  EXPECT_EQ(plain->outputs()[2].size, 1U);
}

TEST(Network, ComputesWhatTheFileSaysForAllThreadsAtOnce) {
  const Network plain = load("plain").value();
  const auto check = [&](float offset) {
    std::vector<float> image(8 * 64);
    for (std::size_t i = 0; i < image.size(); ++i) image[i] = offset + static_cast<float>(i % 64);
    for (int repeat = 0; repeat < 50; ++repeat) {
      const auto out = plain.run(image);
      ASSERT_TRUE(out) << out.error().message;
      for (const float row : (*out)[0]) EXPECT_NEAR(row, offset + 31.5F, 1e-3);
      for (std::size_t c = 0; c < 64; ++c) EXPECT_NEAR((*out)[1][c], offset + static_cast<float>(c), 1e-3);
      EXPECT_NEAR((*out)[2][0], offset + 31.5F - 5, 1e-3);
    }
  };
  std::vector<std::thread> threads;
  threads.reserve(4);
  for (int t = 0; t < 4; ++t) threads.emplace_back(check, 10.0F * static_cast<float>(t));
  for (auto& thread : threads) thread.join();
}

TEST(Network, AnImageOfAnotherSizeIsRefused) {
  const Network plain = load("plain").value();
  EXPECT_TRUE(plain.run(std::vector<float>(512)));
  EXPECT_EQ(plain.run(std::vector<float>(511)).error().code, ErrorCode::bad_input);
  EXPECT_NE(plain.run({}).error().message.find("1x8x64"), std::string::npos);
}

class BadNetwork : public testing::Test {
 protected:
  /// A file of these bytes with this sidecar as a family; its error, which must be one line that names the file.
  std::string refusal(const std::string& bytes, const std::string& json) {
    const auto file = dir.path() / "mine.onnx";
    std::ofstream(file, std::ios::binary) << bytes;
    std::ofstream(file.string() + ".json") << json;
    const auto family = make_family("onnx:" + file.string());
    if (family) return "accepted";
    EXPECT_EQ(family.error().code, ErrorCode::bad_input);
    EXPECT_EQ(family.error().message.find('\n'), std::string::npos) << family.error().message;
    EXPECT_NE(family.error().message.find(file.string()), std::string::npos) << family.error().message;
    return family.error().message;
  }
  static std::string bytes_of(const std::string& name) { return Network::read(network(name)).value(); }
  static bool says(const std::string& message, const std::string& words) {
    return message.find(words) != std::string::npos;
  }

  TempDir dir;
  const std::string side = R"({"rows": 8, "columns": 64, "fov_up_deg": 20, "fov_down_deg": 20, "encoding": "range_m"})";
};

TEST_F(BadNetwork, WhatIsNoOnnxOrCutShortIsRefused) {
  EXPECT_EQ(refusal(bytes_of("plain"), side), "accepted");
  for (const std::string& none :
       {std::string(), std::string("PNG"), side, std::string(5000, '\0'), std::string("\n\x7f")})
    EXPECT_PRED2(says, refusal(none, side), "no ONNX network");
  const std::string whole = bytes_of("plain");
  for (std::size_t size = 0; size < whole.size(); size += 9)
    EXPECT_NE(refusal(whole.substr(0, size), side), "accepted");
}

TEST_F(BadNetwork, AnyByteMayBeDamagedWithoutHarm) {
  const std::string whole = bytes_of("plain");
  std::mt19937 rng(7);
  for (int i = 0; i < 100; ++i) {
    std::string damaged = whole;
    damaged[rng() % damaged.size()] = static_cast<char>(rng());
    refusal(damaged, side);
  }
}

TEST_F(BadNetwork, OtherOutputsInputsAndWhatCanNotBeRunAreNamed) {
  EXPECT_PRED2(says, refusal(bytes_of("other_outputs"), side), "features of 8, w of 64; they must be q");
  EXPECT_PRED2(says, refusal(bytes_of("of_a_vector"), side), "'image' is 1x64");
  EXPECT_PRED2(says, refusal(bytes_of("any_width"), side), "1x2x8x?");
  EXPECT_PRED2(says, refusal(bytes_of("unsupported"), side), "can not be run here");
  EXPECT_PRED2(says, refusal(bytes_of("without_w"), side), "takes an image of 2x8x64");
}

TEST_F(BadNetwork, TheSidecarIsCheckedKeyByKey) {
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = side;
    text.replace(text.find(from), from.size(), to);
    return refusal(bytes_of("plain"), text);
  };
  EXPECT_PRED2(says, with("\"rows\": 8, ", ""), "rows is missing");
  EXPECT_PRED2(says, with("\"rows\": 8, ", ""), std::string(network_image_example));
  EXPECT_PRED2(says, with("\"rows\"", "\"lines\": 1, \"rows\""), "unknown key lines");
  EXPECT_PRED2(says, with("range_m", "metres"), "encoding must be");
  EXPECT_PRED2(says, with("8", "8.5"), "rows must be a whole number");
  EXPECT_PRED2(says, with("64", "63"), "columns must be");
  EXPECT_PRED2(says, with("20", "\"up\""), "fov_up_deg must be a number");
  EXPECT_PRED2(says, with("20", "-20"), "leave nothing between");
  EXPECT_PRED2(says, with("{", ""), "no JSON");
  EXPECT_PRED2(says, refusal(bytes_of("plain"), "[1]"), "no JSON object");
  EXPECT_PRED2(says, refusal(bytes_of("plain"), "{\"\xff\": 1}"), ".json");
  EXPECT_PRED2(says, with("8", "9"), "1x9x64") << "good by itself, but not what the network takes";
}

TEST_F(BadNetwork, MissingFilesAreNamed) {
  const auto absent = make_family("onnx:" + (dir.path() / "none.onnx").string());
  EXPECT_EQ(absent.error().code, ErrorCode::not_found);
  EXPECT_PRED2(says, absent.error().message, "none.onnx: no file");
  EXPECT_PRED2(says, make_family("onnx:" + dir.path().string()).error().message, "no file that can be read");
  std::ofstream(dir.path() / "alone.onnx", std::ios::binary) << bytes_of("plain");
  const auto alone = make_family("onnx:" + (dir.path() / "alone.onnx").string());
  EXPECT_PRED2(says, alone.error().message, "alone.onnx.json: no file");
  EXPECT_PRED2(says, alone.error().message, std::string(network_image_example));
}

TEST(OnnxFamily, DescribesWithTheUsersNetwork) {
  const auto family = make_family("onnx:" + network("plain").string()).value();
  EXPECT_EQ(family->q_size(), 8U);
  EXPECT_EQ(family->w_size(), 64U);
  const Points scan = crossing_scan(0.2);
  const Descriptor d = family->extract(scan).value();
  const RangeImage image = range_image(scan, {8, 64, 20, -20});
  for (std::size_t row = 0; row < 8; ++row) {
    float mean = 0;
    for (std::size_t c = 0; c < 64; ++c) mean += image.at(row, c) / 64;
    EXPECT_NEAR(d.q[row], mean, 1e-3);
  }
  const float mean = std::accumulate(image.range_m.begin(), image.range_m.end(), 0.0F) / 512;
  EXPECT_EQ(d.place_class, mean > 5 ? PlaceClass::junction : PlaceClass::tunnel);
  const Points close(scan.size(), Eigen::Vector3f(1, 0, 0)), far = [&] {
    Points all = scan;
    for (auto& p : all) p *= 10;
    return all;
  }();
  EXPECT_EQ(family->extract(close)->place_class, PlaceClass::tunnel);
  EXPECT_EQ(family->extract(far)->place_class, PlaceClass::junction);
}

TEST(OnnxFamily, WithoutWTheAzimuthProfileFindsTheYaw) {
  const auto family = make_family("onnx:" + network("without_w").string()).value();
  EXPECT_EQ(family->q_size(), 16U);
  ASSERT_EQ(family->w_size(), 64U);
  const Descriptor a = family->extract(crossing_scan(0.2)).value();
  EXPECT_EQ(a.place_class, PlaceClass::unknown);
  for (const double turn_deg : {20.0, 90.0, -150.0}) {
    const Descriptor b = family->extract(crossing_scan(0.2 + turn_deg * degree)).value();
    const auto yaws = family->yaw_difference(a.w, b.w, 2);
    ASSERT_FALSE(yaws.empty());
    EXPECT_NEAR(wrap_rad(yaws[0].yaw_rad - turn_deg * degree), 0, 4 * degree) << turn_deg;
  }
}

TEST(OnnxFamily, TwoNetworksOrTwoImagesAreTwoFamilies) {
  TempDir dir;
  const auto id_of = [&](const std::string& name, double up_deg) {
    const auto file = dir.path() / "same_name.onnx";
    std::ofstream(file, std::ios::binary) << Network::read(network(name)).value();
    std::ofstream(file.string() + ".json") << R"({"rows": 8, "columns": 64, "fov_up_deg": )" << up_deg
                                           << R"(, "fov_down_deg": 20, "encoding": "range_m"})";
    return make_family("onnx:" + file.string()).value()->id();
  };
  const FamilyId plain = id_of("plain", 20);
  EXPECT_EQ(id_of("plain", 20), plain);
  EXPECT_NE(id_of("not_finite", 20).name, plain.name);
  EXPECT_EQ(id_of("plain", 21).name, plain.name);
  EXPECT_NE(id_of("plain", 21).version, plain.version);
  EXPECT_EQ(plain.name.size(), 17U);
  EXPECT_EQ(plain.name.find("onnx-"), 0U);
  EXPECT_EQ(plain, make_family("onnx:" + network("plain").string()).value()->id()) << "wherever the file lies";
}

TEST(OnnxFamily, AScanThatTheNetworkMakesNothingOfIsLostAlone) {
  const auto family = make_family("onnx:" + network("not_finite").string()).value();
  const auto near = family->extract(Points(100, Eigen::Vector3f(1, 0, 0)));
  ASSERT_FALSE(near);
  EXPECT_EQ(near.error().code, ErrorCode::bad_input);
  Points scan = crossing_scan(0.2);
  for (auto& p : scan) p *= 10;
  EXPECT_TRUE(family->extract(scan));
  const auto above = family->extract(Points(100, Eigen::Vector3f(0.1F, 0, 3)));
  ASSERT_FALSE(above);
  EXPECT_NE(above.error().message.find("-20.0 to 20.0 deg"), std::string::npos) << above.error().message;
}

TEST(Learned, GivesAVectorOfLengthOneASignatureAndAClass) {
  const auto family = make_family("learned").value();
  EXPECT_EQ(family->id(), (FamilyId{"learned", 2}));
  EXPECT_EQ(family->w_size(), 64U);
  const Descriptor d = family->extract(crossing_scan(0.2)).value();
  ASSERT_EQ(d.q.size(), family->q_size());
  EXPECT_NEAR(std::inner_product(d.q.begin(), d.q.end(), d.q.begin(), 0.0F), 1, 1e-4);
  EXPECT_EQ(std::count(d.q.end() - open_sky_q_size, d.q.end(), 0.0F), open_sky_q_size) << "underground";
  EXPECT_NE(d.place_class, PlaceClass::unknown);
}

TEST(Learned, SaysWhenAScanIsUnlikeThoseItWasTrainedOn) {
  const auto family = make_family("learned").value();
  const Points usual = crossing_scan(0.2);
  const auto within = [&](double low_deg, double high_deg) {
    Points kept;
    for (const auto& p : usual)
      if (const double deg = std::asin(p.z() / p.norm()) / degree; deg > low_deg && deg < high_deg) kept.push_back(p);
    return kept;
  };
  EXPECT_EQ(family->unfamiliar(usual), "");
  EXPECT_EQ(family->unfamiliar(within(-10, 10)), "") << "a lidar of 20 deg";
  for (const auto& [low, high] : {std::pair{-2.0, 2.0}, std::pair{5.0, 90.0}}) {
    const Points narrow = within(low, high);
    EXPECT_TRUE(family->extract(narrow)) << "it works all the same";
    EXPECT_NE(family->unfamiliar(narrow).find("-11.2 to 11.2 deg"), std::string::npos) << family->unfamiliar(narrow);
  }
}

}  // namespace
}  // namespace headframe
