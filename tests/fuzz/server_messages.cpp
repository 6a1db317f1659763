// Every message that a server may send, to the robot's side of the protocol.
#include <google/protobuf/stubs/logging.h>

#include "client/uplink/surroundings_book.hpp"
#include "client/uplink/uplink_protocol.hpp"
#include "common/wire/capabilities.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace headframe::fuzz {
namespace {

constexpr std::uint64_t keyframes = 6;

class Source : public UplinkSource {
 public:
  std::uint64_t last_sequence() const override { return keyframes; }
  Result<Keyframe> keyframe(std::uint64_t sequence) const override {
    require(sequence >= 1 && sequence <= keyframes);
    Keyframe k;
    k.sequence = sequence;
    k.descriptor.q = {1};
    return k;
  }
  std::uint64_t last_pose_update() const override { return 2; }
  std::uint64_t keyframes_at_update(std::uint64_t number) const override { return 2 * number; }
  Result<std::vector<KeyframePose>> poses(std::uint64_t first, std::uint64_t last) const override {
    require(first >= 1 && first <= last && last <= last_pose_update());
    return std::vector<KeyframePose>{{1, Pose::Identity()}, {2, Pose::Identity()}};
  }
  bool holds_cloud(std::uint64_t sequence) const override { return sequence >= 2 && sequence <= keyframes; }
  std::uint64_t next_held_cloud(std::uint64_t from) const override {
    return from > keyframes ? 0 : std::max<std::uint64_t>(from, 2);
  }
  Result<std::string> cloud(std::uint64_t sequence) const override {
    if (sequence == 3) return failure(ErrorCode::bad_input, "damaged");
    return std::string(1000 * sequence, 'c');
  }
};

Hello hello() { return {{"ant", "s1"}, {"os1", 32, 22, 22, 120}, {{"f", 1}, 1, 0}, CloudPolicy::all, "fuzz", 7}; }

/// What others know goes on to the robot's book, which asks on.
void hear(UplinkProtocol& link, SurroundingsBook& book, std::string_view payload, UplinkProtocol::Time now) {
  std::string frame;
  if (!append_frame(frame, payload)) return;
  for (const UplinkEvent& event : link.receive(frame, now)) {
    const auto* told = std::get_if<SurroundingsMessage>(&event);
    if (!told) continue;
    const auto taken = book.take(*told->message);
    if (taken && taken->next) (void)link.ask_around(*taken->next);
    if (!book.wants_map()) book.want_map({SphereRegion{{0, 0, 0}, 5}});
  }
}

void change_roles(UplinkProtocol& link, std::size_t with) {
  if (!link.welcomed()) return;
  if (with % 16 == 5) link.stand_by();
  if (with % 16 == 6) link.probe(with / 16 % keyframes);
  if (with % 16 == 7 && link.answered()) (void)link.take_over();
}

}  // namespace
}  // namespace headframe::fuzz

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  google::protobuf::SetLogHandler(nullptr);  // as the server does
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace headframe;
  UplinkProtocol::Time now{};
  const fuzz::Source source;
  UplinkProtocol link({}, fuzz::hello(), source, now);
  SurroundingsBook book(20000);
  book.want_trajectories(true);
  book.want_coverage(true);
  book.want_map({SphereRegion{{0, 0, 0}, 5}});
  auto bytes = fuzz::text(data, size);
  std::vector<UplinkEvent> events;
  const auto first = fuzz::take_byte(bytes);
  if (first % 16 == 9) link.stand_by();
  (void)link.next_frame(now, 256, events);
  if (first % 8 != 0) {
    v1::ServerMessage welcome;
    welcome.mutable_welcome()->set_protocol_version(protocol_version);
    welcome.mutable_welcome()->add_capabilities(std::string(surroundings_capability));
    fuzz::hear(link, book, welcome.SerializeAsString(), now);
  }
  for (const auto piece : fuzz::pieces(bytes)) {
    now += std::chrono::milliseconds(200);
    for (std::size_t i = piece.size() % 32; i > 0 && link.next_frame(now, 256, events); --i) continue;
    fuzz::hear(link, book, piece, now);
    (void)link.tick(now);
    (void)link.doubtful(now);
    fuzz::change_roles(link, piece.size());
  }
  return 0;
}
