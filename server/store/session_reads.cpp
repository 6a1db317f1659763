#include "server/store/session_reads.hpp"

#include <utility>

#include "server/store/keyframe_row.hpp"

namespace headframe {

Result<void> read_keyframes(Database& database, SessionId session, std::uint64_t first,
                            const std::function<void(Keyframe)>& visit,
                            const std::function<void(std::uint64_t sequence)>& damaged) {
  std::optional<Keyframe> last;
  std::vector<std::uint64_t> before;  // damaged ones before the first that is intact
  auto read = database.each(
      select_moved_keyframes() + " WHERE k.session=? AND k.sequence>=? ORDER BY k.sequence",
      [&](const Row& row) {
        const auto sequence = static_cast<std::uint64_t>(row.integer(0));
        auto keyframe = moved_keyframe_of(row);
        if (!keyframe) damaged(sequence);
        if (!keyframe && !last) return before.push_back(sequence);
        if (!keyframe) return visit(stand_in(sequence, *last));
        for (const std::uint64_t earlier : std::exchange(before, {})) visit(stand_in(earlier, *keyframe));
        last = *keyframe;
        visit(std::move(*keyframe));
      },
      session, first);
  for (const std::uint64_t sequence : before) visit(stand_in(sequence, {}));
  return read;
}

Result<std::vector<std::uint64_t>> read_cloud_sequences(Database& database, SessionId session) {
  std::vector<std::uint64_t> sequences;
  auto read = database.each(
      "SELECT sequence FROM clouds WHERE session=? ORDER BY sequence",
      [&](const Row& row) { sequences.push_back(static_cast<std::uint64_t>(row.integer(0))); }, session);
  if (!read) return tl::unexpected(read.error());
  return sequences;
}

Result<std::string> read_cloud(Database& database, const KeyframeRef& keyframe) {
  std::optional<std::string> encoded;
  auto read = database.each(
      "SELECT encoded FROM clouds WHERE session=? AND sequence=?", [&](const Row& row) { encoded = row.text(0); },
      keyframe.session, keyframe.sequence);
  if (!read) return tl::unexpected(read.error());
  if (!encoded)
    return failure(ErrorCode::not_found, "no cloud of keyframe " + std::to_string(keyframe.sequence) + " of session " +
                                             std::to_string(keyframe.session) + " is stored");
  return std::move(*encoded);
}

Result<std::optional<FamilyId>> read_family(Database& database, SessionId session) {
  std::optional<FamilyId> family;
  auto read = database.each(
      "SELECT family, family_version FROM sessions WHERE id=?",
      [&](const Row& row) {
        family = {row.text(0), static_cast<int>(row.integer(1))};
      },
      session);
  if (!read) return tl::unexpected(read.error());
  return family;
}

}  // namespace headframe
