#include "common/wire/convert.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "common/wire/frame_codec.hpp"
#include "common/wire/limits.hpp"

namespace headframe {
namespace {

Keyframe some_keyframe() {
  Keyframe k;
  k.sequence = 7;
  k.stamp_s = 1234.5;
  k.T_local_sensor = pose_from_yaw(0.7, {1, -2, 3}) * Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX());
  k.spaciousness_m = 4.5F;
  k.descriptor = {{1.5F, -0.25F}, {65504.0F}, PlaceClass::junction};
  for (std::size_t i = 0; i < k.walls.code.size(); ++i) k.walls.code[i] = static_cast<std::uint8_t>(i);
  k.point_count = 99;
  return k;
}

TEST(Convert, AKeyframeComesBackAsItWas) {
  const Keyframe k = some_keyframe();
  const auto message = to_proto(k);
  ASSERT_TRUE(message) << message.error().message;
  const auto back = from_proto(*message);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->sequence, k.sequence);
  EXPECT_EQ(back->stamp_s, k.stamp_s);
  EXPECT_TRUE(back->T_local_sensor.isApprox(k.T_local_sensor, 1e-12));
  EXPECT_EQ(back->spaciousness_m, k.spaciousness_m);
  EXPECT_EQ(back->descriptor.q, k.descriptor.q);
  EXPECT_EQ(back->descriptor.w, k.descriptor.w);
  EXPECT_EQ(back->descriptor.place_class, k.descriptor.place_class);
  EXPECT_EQ(back->walls.code, k.walls.code);
  EXPECT_EQ(back->point_count, k.point_count);
}

TEST(Convert, DescriptorValuesMustFitBinary16) {
  Keyframe k = some_keyframe();
  k.descriptor.q = {65519.0F};  // rounds to the largest, 65504
  EXPECT_TRUE(to_proto(k));
  k.descriptor.q = {65520.0F};
  EXPECT_FALSE(to_proto(k));
  k.descriptor.q = {std::numeric_limits<float>::quiet_NaN()};
  EXPECT_FALSE(to_proto(k));
  k.descriptor.q.assign(limits::descriptor_floats, 1);
  EXPECT_TRUE(to_proto(k));
  k.descriptor.q.push_back(1);
  EXPECT_FALSE(to_proto(k));
}

TEST(Convert, EveryBadFieldOfAKeyframeIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const v1::Keyframe good = *to_proto(some_keyframe());
  ASSERT_TRUE(from_proto(good));
  using Spoil = std::function<void(v1::Keyframe&)>;
  const std::vector<std::pair<const char*, Spoil>> spoils{
      {"sequence", [](auto& m) { m.set_sequence(0); }},
      {"stamp", [&](auto& m) { m.set_stamp_s(nan); }},
      {"position nan", [&](auto& m) { m.mutable_t_local_sensor()->set_y(nan); }},
      {"position far", [&](auto& m) { m.mutable_t_local_sensor()->set_y(1.1e8); }},
      {"no pose", [](auto& m) { m.clear_t_local_sensor(); }},
      {"quaternion nan", [&](auto& m) { m.mutable_t_local_sensor()->set_qw(nan); }},
      {"spaciousness", [](auto& m) { m.set_spaciousness_m(-1); }},
      {"q odd", [](auto& m) { m.set_q("abc"); }},
      {"q empty", [](auto& m) { m.set_q(""); }},
      {"q infinite", [](auto& m) { m.set_q(std::string("\x00\x7c", 2)); }},
      {"w long", [](auto& m) { m.set_w(std::string(2 * limits::descriptor_floats + 2, '\0')); }},
      {"walls short", [](auto& m) { m.set_walls(std::string(179, '\0')); }},
      {"walls long", [](auto& m) { m.set_walls(std::string(181, '\0')); }},
      {"points", [](auto& m) { m.set_point_count(limits::cloud_points + 1); }},
  };
  for (const auto& [what, spoil] : spoils) {
    v1::Keyframe m = good;
    spoil(m);
    const auto k = from_proto(m);
    ASSERT_FALSE(k) << what;
    EXPECT_EQ(k.error().code, ErrorCode::bad_input) << what;
  }
}

TEST(Convert, APlaceClassOfALaterVersionIsUnknown) {
  v1::Keyframe m = *to_proto(some_keyframe());
  m.set_place_class(static_cast<v1::PlaceClass>(9));
  EXPECT_EQ(from_proto(m)->descriptor.place_class, PlaceClass::unknown);
}

TEST(Convert, NamesBecomeFileNames) {
  EXPECT_TRUE(check_name("robot", "rover-1 (blå)"));
  EXPECT_TRUE(check_name("robot", std::string(limits::name_bytes, 'x')));
  for (const std::string& name :
       {std::string(), std::string(limits::name_bytes + 1, 'x'), std::string("a/b"), std::string("a\nb"),
        std::string("a\0b", 3), std::string("a\x7f"), std::string("."), std::string("..")})
    EXPECT_FALSE(check_name("robot", name)) << name;
}

TEST(Convert, HelloIsCheckedFieldByField) {
  Hello hello{
      {"rover", "s1"}, {"os1-32", 32, 22.5F, 22.5F, 120}, {{"scan_context", 1}, 60, 60}, CloudPolicy::all, "test", 5};
  hello.token = std::string(32, 't');
  hello.enrolment_code = std::string(16, 'c');
  hello.spool_runs = {8, 9};
  const v1::Hello good = to_proto(hello);
  EXPECT_EQ(good.protocol_version(), protocol_version);
  const auto back = from_proto(good);
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->session, hello.session);
  EXPECT_EQ(back->family.id, hello.family.id);
  EXPECT_EQ(back->family.w_size, 60U);
  EXPECT_EQ(back->clouds, CloudPolicy::all);
  EXPECT_EQ(back->spool_id, 5U);
  EXPECT_EQ(back->sensor.fov_down_deg, 22.5F);
  EXPECT_EQ(back->token, hello.token);
  EXPECT_EQ(back->enrolment_code, hello.enrolment_code);
  EXPECT_EQ(back->spool_runs, hello.spool_runs);
  const auto refused = [&](auto spoil) {
    v1::Hello m = good;
    spoil(m);
    return !from_proto(m).has_value();
  };
  EXPECT_TRUE(refused([](auto& m) { m.mutable_session()->set_session(""); }));
  EXPECT_TRUE(refused([](auto& m) { m.mutable_sensor()->set_fov_down_deg(-22.5F); }));
  EXPECT_TRUE(refused([](auto& m) { m.mutable_sensor()->set_beams(4097); }));
  EXPECT_TRUE(refused([](auto& m) { m.mutable_family()->set_q_size(0); }));
  EXPECT_TRUE(refused([](auto& m) { m.mutable_family()->set_q_size(limits::descriptor_floats + 1); }));
  EXPECT_TRUE(refused([](auto& m) { m.set_spool_id(0); }));
  for (const std::size_t size : {1, 31, 33})
    EXPECT_TRUE(refused([&](auto& m) { m.set_token(std::string(size, 't')); }));
  for (const std::size_t size : {15, 17})
    EXPECT_TRUE(refused([&](auto& m) { m.set_enrolment_code(std::string(size, 'c')); }));
  EXPECT_TRUE(refused([](auto& m) { m.add_spool_runs(0); }));
  const auto with_runs = [&](std::size_t count) {
    v1::Hello m = good;
    while (static_cast<std::size_t>(m.spool_runs_size()) < count) m.add_spool_runs(7);
    return m;
  };
  EXPECT_TRUE(from_proto(with_runs(limits::spool_runs)));
  EXPECT_FALSE(from_proto(with_runs(limits::spool_runs + 1)));
  EXPECT_TRUE(refused([](auto& m) { m.set_clouds(static_cast<v1::CloudPolicy>(9)); }));
}

TEST(Convert, SizesOfADescriptorMatchTheHello) {
  const auto completed = [](std::size_t q_size, std::size_t w_size) {
    Keyframe k = some_keyframe();
    return complete(k, {{"f", 1}, q_size, w_size}).has_value();
  };
  EXPECT_TRUE(completed(2, 1));
  EXPECT_FALSE(completed(1, 1));
  EXPECT_FALSE(completed(2, 0));
}

TEST(Convert, ZerosAtTheEndOfQDoNotTravelAndComeBack) {
  for (const std::vector<float>& q : {std::vector<float>{1, 0, 2, 0, 0}, {1, 2}, {0, 0, 0}, {0, -1}}) {
    Keyframe k = some_keyframe();
    k.descriptor.q = q;
    const auto sent = to_proto(k).value();
    EXPECT_EQ(sent.q().size(), q.size() == 5 ? 6U : q.size() == 3 ? 2U : 4U);
    auto received = from_proto(sent).value();
    ASSERT_TRUE(complete(received, {{"f", 1}, q.size(), k.descriptor.w.size()}));
    EXPECT_EQ(received.descriptor.q, q);
  }
}

}  // namespace
}  // namespace headframe
