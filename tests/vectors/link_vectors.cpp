// Frames, names, enrolments, and what the server's side of the protocol makes of messages.
#include <functional>
#include <limits>

#include "common/security/enrolment.hpp"
#include "common/security/secret.hpp"
#include "common/wire/convert.hpp"
#include "common/wire/frame_codec.hpp"
#include "common/wire/limits.hpp"
#include "server/net/robot_protocol.hpp"
#include "tests/vectors/vectors.hpp"

namespace headframe::vectors {
namespace {

std::string framed(std::string_view payload) {
  std::string out;
  if (!append_frame(out, payload)) throw std::logic_error("a payload that fits no frame");
  return out;
}

File frames() {
  Json good = Json::array(), bad = Json::array();
  for (const std::string& payload : {std::string("\x3a\x02\x08\x05", 4), std::string(300, 'a')})
    good.push_back({{"payload", to_hex(payload)}, {"frame", to_hex(framed(payload))}});
  for (const std::string_view header : {"00000000", "00040001", "ffffffff", "47455420"}) {
    FrameReader reader;
    reader.feed(*from_hex(header, 4));
    if (reader.next()) throw std::logic_error("a header that is no longer refused");
    bad.push_back({{"bytes", header}});
  }
  return {"frames", {{"frames", good}, {"refused", bad}}};
}

File names() {
  const std::vector<std::string> texts{"scout",
                                       "Stollen 7",
                                       "矿井-2",
                                       std::string(128, 'n'),
                                       std::string(129, 'n'),
                                       "",
                                       ".",
                                       "..",
                                       "...",
                                       "a/b",
                                       "tab\there",
                                       "line\nbreak",
                                       "del\x7f",
                                       "\xc3\xa9",
                                       "\xc2\x85",
                                       "\xe2\x80\x8b",
                                       "\xe2\x80\xae",
                                       "\xe2\x80\xa8",
                                       "\xef\xbb\xbf",
                                       "\xc0\xaf",
                                       "\xed\xa0\x80",
                                       "\xff",
                                       "\xf0\x9f\xa4\x96",
                                       "\xf4\x90\x80\x80"};
  Json rows = Json::array();
  for (const auto& text : texts)
    rows.push_back({{"utf8", to_hex(text)}, {"accepted", check_name("a", text).has_value()}});
  return {"names", {{"names", rows}}};
}

File enrolments() {
  const std::string print(64, 'a'), code = "0123456789abcdefFEDCBA9876543210", start = "hf1-" + print;
  const std::string good = start + "-" + code;
  Json rows = Json::array();
  for (const std::string& text : {good, "hf2" + good.substr(3), start + code, good + "0", "hf1-g" + good.substr(5)}) {
    const auto read = parse_enrolment(text);
    Json row{{"text", text}, {"accepted", read.has_value()}};
    if (read) row.update({{"fingerprint", to_hex(read->fingerprint)}, {"code", to_hex(read->code)}});
    rows.push_back(row);
  }
  return {"enrolments", {{"enrolments", rows}}};
}

v1::RobotMessage good_hello() {
  Hello hello{{"scout", "monday"},
              {"os1-32", 32, 22.5F, 22.5F, 120},
              {{"scan_context", 1}, 3, 2},
              CloudPolicy::on_request,
              "vectors",
              77};
  hello.token = std::string(32, 't');
  hello.spool_runs = {5, 6};
  hello.capabilities = {"cloud_refusal", "something_new"};
  v1::RobotMessage message;
  *message.mutable_hello() = to_proto(hello);
  return message;
}

v1::RobotMessage good_keyframe(std::uint64_t sequence) {
  Keyframe keyframe;
  keyframe.sequence = sequence;
  keyframe.stamp_s = 1234.5;
  keyframe.T_local_sensor = pose_from_yaw(0.5, {1, -2, 3});
  keyframe.spaciousness_m = 4.5F;
  keyframe.descriptor = {{1.5F, 0}, {0.25F, 2}, PlaceClass::tunnel};
  keyframe.walls.code.fill(100);
  keyframe.point_count = 9;
  v1::RobotMessage message;
  *message.mutable_keyframe() = to_proto(keyframe).value();
  return message;
}

/// What a server that has taken the messages before answers to the last of them.
Json answer(const std::vector<v1::RobotMessage>& sent) {
  const RobotProtocol::Time now{};
  RobotProtocol server(RobotLimits{}, now);
  for (const auto& message : sent) {
    server.receive(framed(message.SerializeAsString()), now);
    while (auto event = server.next()) {
      if (std::holds_alternative<HelloReceived>(*event)) server.welcome({});
      if (auto* cloud = std::get_if<CloudArrived>(&*event)) {
        const auto decodes = RobotProtocol::check(*cloud);
        (void)server.checked(std::move(*cloud), decodes);
      }
    }
  }
  FrameReader reader;
  reader.feed(server.take_output());
  Json said = "nothing";
  while (const auto payload = reader.next().value_or(std::nullopt)) {
    v1::ServerMessage message;
    if (!message.ParseFromString(*payload)) throw std::logic_error("an answer that is no message");
    if (message.has_error())
      said = {{"error", v1::ErrorKind_Name(message.error().kind()).substr(11)},
              {"permanent", message.error().permanent()}};
    if (message.has_cloud_refusal()) said = {{"cloud_refusal", message.cloud_refusal().sequence()}};
    if (message.has_pong()) said = {{"pong", message.pong().nonce()}};
  }
  return said;
}

using Change = std::function<void(v1::RobotMessage&)>;

Json row_of(const std::string& what, const std::vector<v1::RobotMessage>& sent) {
  Json bytes = Json::array();
  for (const auto& message : sent) bytes.push_back(to_hex(message.SerializeAsString()));
  return {{"what", what}, {"messages", bytes}, {"answer", answer(sent)}};
}

Json hellos() {
  const std::vector<std::pair<std::string, Change>> changes{
      {"a hello as it should be", [](auto&) {}},
      {"protocol version 2", [](auto& m) { m.mutable_hello()->set_protocol_version(2); }},
      {"no session", [](auto& m) { m.mutable_hello()->clear_session(); }},
      {"a robot name with a slash", [](auto& m) { m.mutable_hello()->mutable_session()->set_robot("a/b"); }},
      {"4097 beams", [](auto& m) { m.mutable_hello()->mutable_sensor()->set_beams(4097); }},
      {"a negative field of view", [](auto& m) { m.mutable_hello()->mutable_sensor()->set_fov_down_deg(-15); }},
      {"q_size 0", [](auto& m) { m.mutable_hello()->mutable_family()->set_q_size(0); }},
      {"q_size 4096", [](auto& m) { m.mutable_hello()->mutable_family()->set_q_size(4096); }},
      {"q_size 4097", [](auto& m) { m.mutable_hello()->mutable_family()->set_q_size(4097); }},
      {"w_size 0", [](auto& m) { m.mutable_hello()->mutable_family()->set_w_size(0); }},
      {"cloud policy 3", [](auto& m) { m.mutable_hello()->set_clouds(static_cast<v1::CloudPolicy>(3)); }},
      {"software of 129 bytes", [](auto& m) { m.mutable_hello()->set_software(std::string(129, 's')); }},
      {"spool_id 0", [](auto& m) { m.mutable_hello()->set_spool_id(0); }},
      {"a token of 31 bytes", [](auto& m) { m.mutable_hello()->set_token(std::string(31, 't')); }},
      {"a code of 15 bytes", [](auto& m) { m.mutable_hello()->set_enrolment_code(std::string(15, 'c')); }},
      {"a spool run of 0", [](auto& m) { m.mutable_hello()->add_spool_runs(0); }},
      {"65 spool runs",
       [](auto& m) {
         for (int i = 2; i < 65; ++i) m.mutable_hello()->add_spool_runs(9);
       }},
      {"64 spool runs",
       [](auto& m) {
         for (int i = 2; i < 64; ++i) m.mutable_hello()->add_spool_runs(9);
       }},
      {"capabilities that are no names", [](auto& m) {
         m.mutable_hello()->add_capabilities("NO NAME");
         m.mutable_hello()->add_capabilities(std::string(33, 'x'));
       }}};
  Json rows = Json::array();
  for (const auto& [what, change] : changes) {
    auto message = good_hello();
    change(message);
    rows.push_back(row_of(what, {message}));
  }
  return rows;
}

Json keyframes() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<std::string, Change>> changes{
      {"a keyframe as it should be", [](auto&) {}},
      {"sequence 0", [](auto& m) { m.mutable_keyframe()->set_sequence(0); }},
      {"sequence 2 first: a hole", [](auto& m) { m.mutable_keyframe()->set_sequence(2); }},
      {"a stamp that is not finite", [=](auto& m) { m.mutable_keyframe()->set_stamp_s(nan); }},
      {"no pose", [](auto& m) { m.mutable_keyframe()->clear_t_local_sensor(); }},
      {"x of 1e8", [](auto& m) { m.mutable_keyframe()->mutable_t_local_sensor()->set_x(1e8); }},
      {"x beyond 1e8", [](auto& m) { m.mutable_keyframe()->mutable_t_local_sensor()->set_x(1.001e8); }},
      {"a quaternion of length 2",
       [](auto& m) {
         auto& T = *m.mutable_keyframe()->mutable_t_local_sensor();
         T.set_qw(2 * T.qw());
         T.set_qz(2 * T.qz());
       }},
      {"a quaternion of length 0",
       [](auto& m) {
         auto& T = *m.mutable_keyframe()->mutable_t_local_sensor();
         T.set_qw(0);
         T.set_qz(0);
       }},
      {"spaciousness -1", [](auto& m) { m.mutable_keyframe()->set_spaciousness_m(-1); }},
      {"q empty", [](auto& m) { m.mutable_keyframe()->clear_q(); }},
      {"q of an odd number of bytes", [](auto& m) { m.mutable_keyframe()->set_q("abc"); }},
      {"q of one number, zeros left out", [](auto& m) { m.mutable_keyframe()->set_q(std::string("\x00\x3e", 2)); }},
      {"q longer than the hello says", [](auto& m) { m.mutable_keyframe()->set_q(std::string(8, '\0')); }},
      {"q with an infinity", [](auto& m) { m.mutable_keyframe()->set_q(std::string("\x00\x7c", 2)); }},
      {"w shorter than the hello says", [](auto& m) { m.mutable_keyframe()->set_w(std::string(2, '\0')); }},
      {"179 walls", [](auto& m) { m.mutable_keyframe()->set_walls(std::string(179, 'w')); }},
      {"a place class that is not known",
       [](auto& m) { m.mutable_keyframe()->set_place_class(static_cast<v1::PlaceClass>(9)); }},
      {"4000001 points", [](auto& m) { m.mutable_keyframe()->set_point_count(4'000'001); }}};
  Json rows = Json::array();
  for (const auto& [what, change] : changes) {
    auto message = good_keyframe(1);
    change(message);
    rows.push_back(row_of(what, {good_hello(), message}));
  }
  return rows;
}

v1::RobotMessage chunk(std::uint64_t sequence, std::uint32_t total, std::uint32_t offset, const std::string& data) {
  v1::RobotMessage message;
  auto& c = *message.mutable_cloud_chunk();
  c.set_sequence(sequence);
  c.set_total_bytes(total);
  c.set_offset(offset);
  c.set_data(data);
  return message;
}

Json live_states() {
  const std::vector<std::pair<std::string, Change>> changes{
      {"how the robot is", [](auto&) {}},
      {"how it is, without a pose", [](auto& m) { m.mutable_live()->clear_t_local_sensor(); }},
      {"a pose without a rotation", [](auto& m) { m.mutable_live()->mutable_t_local_sensor()->Clear(); }},
      {"a battery of 1", [](auto& m) { m.mutable_live()->set_battery(1); }},
      {"a battery beyond 1", [](auto& m) { m.mutable_live()->set_battery(1.5F); }},
      {"health of 256 bytes", [](auto& m) { m.mutable_live()->set_health(std::string(256, 'h')); }},
      {"health of 257 bytes", [](auto& m) { m.mutable_live()->set_health(std::string(257, 'h')); }}};
  Json rows = Json::array();
  for (const auto& [what, change] : changes) {
    v1::RobotMessage message;
    message.mutable_live()->set_stamp_s(12.5);
    *message.mutable_live()->mutable_t_local_sensor() = good_keyframe(1).keyframe().t_local_sensor();
    message.mutable_live()->set_health("well");
    message.set_backlog(2);
    change(message);
    rows.push_back(row_of(what, {good_hello(), message}));
  }
  return rows;
}

Json other_messages() {
  v1::RobotMessage ping, goodbye, unknown, localize;
  (void)localize.mutable_localize();
  ping.mutable_ping()->set_nonce(41);
  goodbye.mutable_goodbye()->set_complete(true);
  unknown.set_backlog(3);
  const auto hello = good_hello(), one = good_keyframe(1), two = good_keyframe(2);
  return {row_of("a keyframe before the hello", {one}),
          row_of("a second hello", {hello, hello}),
          row_of("a ping", {hello, ping}),
          row_of("a message without a body", {hello, unknown}),
          row_of("a repeat", {hello, one, two, one}),
          row_of("where am I", {hello, one, localize}),
          row_of("where am I, before the hello", {localize}),
          row_of("a keyframe after a complete goodbye", {hello, one, goodbye, two}),
          row_of("a repeat after a complete goodbye", {hello, one, goodbye, one}),
          row_of("a chunk before its keyframe", {hello, chunk(1, 4, 0, "abcd")}),
          row_of("a chunk of a cloud that goes on", {hello, one, chunk(1, 8, 0, "abcd")}),
          row_of("a cloud that does not decode", {hello, one, chunk(1, 4, 0, "abcd")}),
          row_of("an empty chunk", {hello, one, chunk(1, 4, 0, "")}),
          row_of("a chunk that leaves a gap", {hello, one, chunk(1, 9, 0, "abcd"), chunk(1, 9, 5, "e")}),
          row_of("a chunk of another total", {hello, one, chunk(1, 9, 0, "abcd"), chunk(1, 8, 4, "e")}),
          row_of("a cloud over 16 MiB", {hello, one, chunk(1, limits::cloud_bytes + 1, 0, "abcd")})};
}

}  // namespace

std::vector<File> link_files() {
  return {frames(),
          names(),
          enrolments(),
          {"messages",
           {{"hellos", hellos()}, {"keyframes", keyframes()}, {"live", live_states()}, {"others", other_messages()}}}};
}

}  // namespace headframe::vectors
