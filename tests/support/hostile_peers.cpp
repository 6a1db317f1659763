#include "tests/support/hostile_peers.hpp"

#include <zstd.h>

#include <memory>

#include "common/security/secret.hpp"
#include "tests/support/tls_peer.hpp"

namespace headframe::test {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::size_t flood = 300;

std::string answer_to(const HostileTarget& target, const std::string& bytes) {
  TlsPeer peer(target);
  peer.send(bytes);
  return peer.until_closed();
}

std::string wrong_version(const HostileTarget& target) {
  v1::RobotMessage message;
  *message.mutable_hello() = to_proto(hello_of(target.accomplice, target.token));
  message.mutable_hello()->set_protocol_version(7);
  return answer_to(target, frame(message));
}

std::string wrong_token(const HostileTarget& target) {
  return answer_to(target, hello_frame(hello_of(target.victim, random_secret(token_bytes))));
}

std::string other_robots_session(const HostileTarget& target) {
  return answer_to(target, hello_frame(hello_of(target.victim, target.token)));
}

std::string replayed_code(const HostileTarget& target) {
  return answer_to(target, hello_frame(hello_of(target.accomplice, random_secret(token_bytes), target.used_code)));
}

std::string four_gigabytes(const HostileTarget& target) { return answer_to(target, std::string(4, '\xff')); }

/// As the accomplice, who is let in.
std::string from_within(const HostileTarget& target, const std::string& bytes) {
  TlsPeer peer(target);
  peer.greet(accomplice_hello(target, to_hex(random_secret(8))));
  peer.send(bytes);
  while (const auto message = peer.read()) {
    if (message->has_error()) return message->error().message();
    if (message->has_cloud_refusal()) return message->cloud_refusal().reason();
  }
  return "";
}

std::string zip_bomb(const HostileTarget& target) {
  const std::string zeros(64 << 20, '\0');
  std::string bomb(ZSTD_compressBound(zeros.size()), '\0');
  bomb.resize(ZSTD_compress(bomb.data(), bomb.size(), zeros.data(), zeros.size(), 1));
  return from_within(target, keyframe_frame(line_keyframe(1)) + chunk_frame(1, bomb.size(), 0, bomb));
}

std::string huge_descriptor(const HostileTarget& target) {
  Keyframe keyframe = line_keyframe(1);
  keyframe.descriptor.q.assign(4096, 1);
  return from_within(target, keyframe_frame(keyframe));
}

std::string huge_family(const HostileTarget& target) {
  v1::RobotMessage message;
  *message.mutable_hello() = to_proto(hello_of(target.accomplice, target.token));
  message.mutable_hello()->mutable_family()->set_q_size(1U << 30U);
  return answer_to(target, frame(message));
}

std::string no_text(const HostileTarget& target) {
  std::string hello = hello_frame(hello_of(target.accomplice, target.token));
  const auto name = hello.find(target.accomplice);
  hello.replace(name, target.accomplice.size(), target.accomplice.size(), '\xff');
  return answer_to(target, hello);
}

std::string slow_loris(const HostileTarget& target) {
  TlsPeer peer(target);
  const std::string hello = hello_frame(hello_of(target.accomplice, target.token));
  peer.send(hello.substr(0, 10));
  return peer.until_closed();
}

std::string connection_flood(const HostileTarget& target) {
  asio::io_context io;
  std::vector<std::unique_ptr<tcp::socket>> sockets;
  sockets.reserve(flood);
  for (std::size_t i = 0; i < flood; ++i) {
    sockets.push_back(std::make_unique<tcp::socket>(io));
    error_code full;
    sockets.back()->connect({asio::ip::make_address(target.server.host), target.server.port}, full);
  }
  std::array<char, 16> bytes{};
  error_code closed;
  sockets.front()->read_some(asio::buffer(bytes), closed);  // the oldest makes room for the newest
  return closed ? "" : "something";
}

}  // namespace

void enrol_accomplice(const HostileTarget& target) {
  TlsPeer(target).greet(hello_of(target.accomplice, target.token, target.used_code));
}

const std::vector<HostilePeer>& hostile_peers() {
  static const std::vector<HostilePeer> peers{
      {"wrong version", "robot speaks protocol 7", wrong_version},
      {"wrong token", "this is not its credential", wrong_token},
      {"another robot's session", "this is not its credential", other_robots_session},
      {"replayed enrolment code", "was used", replayed_code},
      {"4 GB length prefix", "4294967295 bytes", four_gigabytes},
      {"zip-bomb cloud", "announced", zip_bomb},
      {"huge descriptor", "the hello announced", huge_descriptor},
      {"huge family", "q has 1 to 4096", huge_family},
      {"name that is no text", "no RobotMessage", no_text},
      {"slowloris", "no hello within", slow_loris},
      {"connection flood", "", connection_flood},
  };
  return peers;
}

}  // namespace headframe::test
