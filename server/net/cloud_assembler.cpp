#include "server/net/cloud_assembler.hpp"

#include "common/wire/limits.hpp"

namespace headframe {

Result<std::optional<std::string>> CloudAssembler::add(std::uint64_t sequence, std::size_t total_bytes,
                                                       std::size_t offset, const std::string& data) {
  const auto bad = [&](const std::string& what) { return failure(ErrorCode::bad_input, what); };
  if (total_bytes == 0 || total_bytes > limits::cloud_bytes)
    return bad(std::to_string(total_bytes) + " bytes announced, 1 to " + std::to_string(limits::cloud_bytes) +
               " are allowed");
  if (data.empty()) return bad("an empty chunk");
  if (offset == 0) forget(sequence);
  auto it = open_.find(sequence);
  const std::size_t have = it == open_.end() ? 0 : it->second.bytes.size();
  if (offset != have || (have > 0 && it->second.total_bytes != total_bytes) || data.size() > total_bytes - have)
    return bad("chunk of " + std::to_string(data.size()) + " bytes at " + std::to_string(offset) + " of " +
               std::to_string(total_bytes) + " does not follow the " + std::to_string(have) + " bytes before it");
  if (it == open_.end()) {
    if (open_.size() == open_clouds) return bad("more than " + std::to_string(open_clouds) + " clouds at a time");
    it = open_.emplace(sequence, Open{total_bytes, {}}).first;
  }
  if (bytes_ + data.size() > open_bytes)
    return bad("more than " + std::to_string(open_bytes) + " bytes of unfinished clouds");
  it->second.bytes += data;
  bytes_ += data.size();
  if (it->second.bytes.size() < total_bytes) return std::nullopt;
  std::string whole = std::move(it->second.bytes);
  bytes_ -= whole.size();
  open_.erase(it);
  return whole;
}

void CloudAssembler::forget(std::uint64_t sequence) {
  const auto it = open_.find(sequence);
  if (it == open_.end()) return;
  bytes_ -= it->second.bytes.size();
  open_.erase(it);
}

}  // namespace headframe
