#include "tests/bench/descriptors/trial.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/wire/convert.hpp"
#include "server/place/descriptor_index.hpp"
#include "tests/mine/parallel.hpp"

namespace headframe::bench {
namespace {

Result<v1::Keyframe> message_of(const Descriptor& descriptor) {
  Keyframe keyframe;
  keyframe.sequence = 1;
  keyframe.descriptor = descriptor;
  return to_proto(keyframe);
}

Descriptor after_the_wire(const Descriptor& descriptor) {
  const auto sent = message_of(descriptor);
  if (!sent) return {};
  auto received = from_proto(*sent);
  if (!received || !complete(*received, {{}, descriptor.q.size(), descriptor.w.size()})) return {};
  return std::move(received->descriptor);
}

/// Errors of the best yaw, and of the better of the two best.
void judge_yaw(const std::vector<YawScore>& yaws, double truth_rad, Answer& answer) {
  for (const YawScore& yaw : yaws) {
    const double error_deg = std::abs(wrap_rad(yaw.yaw_rad - truth_rad)) * 180 / std::numbers::pi;
    if (answer.yaw_error_deg < 0) answer.yaw_error_deg = answer.yaw_top2_error_deg = error_deg;
    answer.yaw_top2_error_deg = std::min(answer.yaw_top2_error_deg, error_deg);
  }
}

}  // namespace

std::vector<Descriptor> describe(const DescriptorFamily& family, const Drive& drive, double turned_rad) {
  std::vector<Descriptor> out(drive.size());
  mine::for_each_index(drive.size(), [&](std::size_t i) {
    const Points& seen = drive[i].points_level;
    const auto made = turned_rad == 0 ? family.extract(seen) : family.extract(turned(seen, turned_rad));
    if (made) out[i] = after_the_wire(*made);
  });
  return out;
}

std::size_t wire_bytes(const Descriptor& descriptor) {
  const auto message = message_of(descriptor);
  return message ? message->q().size() + message->w().size() : 0;
}

Answers ask(const DescriptorFamily& family, const std::vector<Descriptor>& a, const std::vector<Descriptor>& b,
            const Truth& truth) {
  const auto index = make_exact_index(family.q_size());
  for (std::size_t i = 0; i < a.size(); ++i)
    if (!a[i].q.empty()) index->add({1, i}, a[i].q);
  Answers answers(b.size());
  for (std::size_t j = 0; j < b.size(); ++j) {
    const auto& right = truth.right[j];
    answers[j].answerable = !right.empty();
    if (b[j].q.empty()) continue;
    const auto neighbours = index->nearest(b[j].q, index->size());
    if (neighbours.empty()) continue;
    answers[j].distance = neighbours.front().squared_distance;
    const auto first = std::find_if(neighbours.begin(), neighbours.end(), [&](const PlaceNeighbour& n) {
      return std::binary_search(right.begin(), right.end(), n.keyframe.sequence);
    });
    if (first == neighbours.end()) continue;
    answers[j].rank = static_cast<std::size_t>(first - neighbours.begin()) + 1;
    const std::size_t i = first->keyframe.sequence;
    judge_yaw(family.yaw_difference(a[i].w, b[j].w, 2), truth.yaw_difference_rad(i, j), answers[j]);
  }
  return answers;
}

}  // namespace headframe::bench
