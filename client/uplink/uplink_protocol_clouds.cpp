// Which cloud is sent when, and the server's answers about them.
#include <algorithm>

#include "client/uplink/uplink_protocol.hpp"
#include "common/cloud/cloud_codec.hpp"
#include "common/wire/limits.hpp"

namespace headframe {

void UplinkProtocol::on_cloud_ack(std::uint64_t sequence, Events& events) {
  if (clouds_in_flight_.erase(sequence) == 0 && carried_alone_)
    return end(events, ErrorCode::bad_input, "from the server: an ack of a cloud that was not sent", false);
  events.emplace_back(CloudsDurable{sequence, sequence});
}

/// It may be partly sent; the rest is dropped.
void UplinkProtocol::on_cloud_refusal(const v1::CloudRefusal& message, Events& events) {
  const auto sequence = message.sequence();
  bool sent = clouds_in_flight_.erase(sequence) > 0;
  for (auto* transfer : {&requested_transfer_, &background_transfer_})
    if (*transfer && (*transfer)->sequence == sequence) {
      sent = true;
      transfer->reset();
    }
  if (!sent) return;  // acknowledged twice, or before it was started again
  events.emplace_back(CloudRefused{sequence, printable_text(message.reason())});
}

bool UplinkProtocol::wanted(std::uint64_t sequence) const {
  return clouds_in_flight_.contains(sequence) || (requested_transfer_ && requested_transfer_->sequence == sequence) ||
         (background_transfer_ && background_transfer_->sequence == sequence) ||
         std::find(requested_.begin(), requested_.end(), sequence) != requested_.end();
}

void UplinkProtocol::on_submap_request(const v1::SubmapRequest& message) {
  v1::RobotMessage answer;
  for (const auto sequence : message.sequences()) {
    if (hello_.clouds == CloudPolicy::never || !source_.holds_cloud(sequence))
      answer.mutable_submap_unavailable()->add_sequences(sequence);
    else if (!wanted(sequence))
      requested_.push_back(sequence);
  }
  if (answer.submap_unavailable().sequences_size() > 0) queue(answer);
}

void UplinkProtocol::queue_next_chunk(std::size_t chunk_bytes, Events& events) {
  while (!requested_transfer_ && !requested_.empty() && clouds_in_flight_.size() < limits_.clouds_in_flight &&
         requested_.front() <= sent_keyframes_) {
    const auto sequence = requested_.front();
    requested_.pop_front();
    begin(requested_transfer_, sequence, events);
  }
  if (requested_transfer_) return queue_chunk(requested_transfer_, chunk_bytes);
  while (!background_transfer_ && hello_.clouds == CloudPolicy::all &&
         clouds_in_flight_.size() < limits_.clouds_in_flight) {
    const auto sequence = next_background();
    if (sequence == 0) return;
    begin(background_transfer_, sequence, events);
  }
  if (background_transfer_) queue_chunk(background_transfer_, chunk_bytes);
}

std::uint64_t UplinkProtocol::next_background() {
  while (true) {
    const auto sequence = source_.next_held_cloud(background_from_);
    if (sequence == 0 || sequence > sent_keyframes_) return 0;
    background_from_ = sequence + 1;
    if (!wanted(sequence)) return sequence;
  }
}

void UplinkProtocol::begin(std::optional<Transfer>& transfer, std::uint64_t sequence, Events& events) {
  auto bytes = source_.cloud(sequence);
  if (bytes && !takes_intensity_)  // a damaged cloud is sent as it is; the server will report it
    if (auto plain = without_intensity(*bytes); plain) bytes = std::move(*plain);
  if (bytes && !bytes->empty() && bytes->size() <= limits::cloud_bytes) {
    transfer = Transfer{sequence, std::move(*bytes), 0};
    return;
  }
  v1::RobotMessage gone;
  gone.mutable_submap_unavailable()->add_sequences(sequence);
  queue(gone);
  events.emplace_back(CloudUnreadable{
      sequence, bytes ? Error{ErrorCode::bad_input, "a cloud of an impossible size"} : std::move(bytes.error())});
}

void UplinkProtocol::queue_chunk(std::optional<Transfer>& transfer, std::size_t chunk_bytes) {
  v1::RobotMessage message;
  auto& chunk = *message.mutable_cloud_chunk();
  const std::size_t n = std::min({limits::chunk_bytes, chunk_bytes, transfer->bytes.size() - transfer->offset});
  chunk.set_sequence(transfer->sequence);
  chunk.set_total_bytes(static_cast<std::uint32_t>(transfer->bytes.size()));
  chunk.set_offset(static_cast<std::uint32_t>(transfer->offset));
  chunk.set_data(transfer->bytes.data() + transfer->offset, n);
  queue(message);
  transfer->offset += n;
  if (transfer->offset < transfer->bytes.size()) return;
  clouds_in_flight_.insert(transfer->sequence);
  transfer.reset();
}

}  // namespace headframe
