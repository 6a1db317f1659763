#include "server/store/keyframe_row.hpp"

#include <algorithm>

#include "server/store/columns.hpp"
#include "server/store/pose_rows.hpp"
#include "server/store/row_checksum.hpp"

namespace headframe {
namespace {

/// Rotations are computed from quaternions; all other values are stored as received.
bool same_pose(const Pose& a, const Pose& b) {
  return a.translation() == b.translation() && (a.linear() - b.linear()).cwiseAbs().maxCoeff() < 1e-9;
}

std::int64_t checksum(std::int64_t session, const Keyframe& k) {
  RowChecksum sum;
  sum.add(static_cast<std::uint64_t>(session)).add(k.sequence).add(k.stamp_s).add(pose_blob(k.T_local_sensor));
  sum.add(double{k.spaciousness_m}).add(floats_blob(k.descriptor.q)).add(floats_blob(k.descriptor.w));
  sum.add(static_cast<std::uint64_t>(k.descriptor.place_class)).add(std::uint64_t{k.point_count});
  return sum.add({reinterpret_cast<const char*>(k.walls.code.data()), k.walls.code.size()}).value();
}

}  // namespace

std::string select_keyframes() {
  return "SELECT sequence, stamp_s, T_local_sensor, spaciousness_m, q, w, place_class, walls, point_count, checksum,"
         " session FROM keyframes";
}

std::optional<Keyframe> keyframe_of(const Row& row) {
  Keyframe k;
  k.sequence = static_cast<std::uint64_t>(row.integer(0));
  k.stamp_s = row.real(1);
  k.T_local_sensor = pose_from_blob(row.blob(2));
  k.spaciousness_m = static_cast<float>(row.real(3));
  k.descriptor.q = floats_from_blob(row.blob(4));
  k.descriptor.w = floats_from_blob(row.blob(5));
  k.descriptor.place_class = static_cast<PlaceClass>(row.integer(6));
  const auto walls = row.blob(7);
  std::copy_n(walls.begin(), std::min(walls.size(), k.walls.code.size()), k.walls.code.begin());
  k.point_count = static_cast<std::uint32_t>(row.integer(8));
  if (!row.is_null(9) && row.integer(9) != checksum(row.integer(10), k)) return std::nullopt;
  return k;
}

std::string select_moved_keyframes() {
  return "SELECT k.sequence, k.stamp_s, k.T_local_sensor, k.spaciousness_m, k.q, k.w, k.place_class, k.walls,"
         " k.point_count, k.checksum, k.session, m.checksum, m.T_local_sensor FROM keyframes k LEFT JOIN moved_poses m"
         " ON m.session=k.session AND m.sequence=k.sequence";
}

std::optional<Keyframe> moved_keyframe_of(const Row& row) {
  auto keyframe = keyframe_of(row);
  if (!keyframe || row.is_null(11)) return keyframe;
  if (row.integer(11) != pose_checksum(row.integer(10), keyframe->sequence, row.blob(12))) return std::nullopt;
  keyframe->T_local_sensor = pose_from_blob(row.blob(12));
  return keyframe;
}

Keyframe stand_in(std::uint64_t sequence, const Keyframe& neighbour) {
  Keyframe k;
  k.sequence = sequence;
  k.stamp_s = neighbour.stamp_s;
  k.T_local_sensor = neighbour.T_local_sensor;
  return k;
}

Result<void> insert_keyframe(Database& database, std::int64_t session, const Keyframe& k,
                             const Database::Changed& stored) {
  const std::string T = pose_blob(k.T_local_sensor);
  const std::string q = floats_blob(k.descriptor.q), w = floats_blob(k.descriptor.w);
  const std::string walls(k.walls.code.begin(), k.walls.code.end());
  const auto make_row = [&](std::string_view sql) {
    return database.run_counted(sql, stored, session, k.sequence, k.stamp_s, Blob{T}, double{k.spaciousness_m}, Blob{q},
                                Blob{w}, static_cast<int>(k.descriptor.place_class), Blob{walls}, k.point_count,
                                checksum(session, k));
  };
  if (database.answers_from_afar())
    return make_row(
        "INSERT INTO keyframes SELECT ?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11 WHERE ?2 = 1 +"
        " (SELECT coalesce(max(sequence), 0) FROM keyframes WHERE session=?1)"
        " AND EXISTS (SELECT 1 FROM sessions WHERE id=?1)");
  const auto last = last_keyframe(database, session);  // SQLite takes half the time for two simple statements
  if (!last) return tl::unexpected(last.error());
  if (k.sequence == *last + 1) return make_row("INSERT INTO keyframes VALUES (?,?,?,?,?,?,?,?,?,?,?)");
  stored(0);
  return {};
}

Result<std::uint64_t> last_keyframe(Database& database, std::int64_t session) {
  std::uint64_t last = 0;
  auto read = database.each(
      "SELECT coalesce(max(sequence), 0) FROM keyframes WHERE session=?",
      [&](const Row& row) { last = static_cast<std::uint64_t>(row.integer(0)); }, session);
  if (!read) return tl::unexpected(read.error());
  return last;
}

const char* difference(const Keyframe& stored, const Keyframe& repeated) {
  const Descriptor &d = stored.descriptor, &e = repeated.descriptor;
  if (stored.stamp_s != repeated.stamp_s) return "another stamp";
  if (!same_pose(stored.T_local_sensor, repeated.T_local_sensor)) return "another pose";
  if (d.q != e.q || d.w != e.w || d.place_class != e.place_class) return "another descriptor";
  if (stored.walls.code != repeated.walls.code) return "other walls";
  if (stored.point_count != repeated.point_count || stored.spaciousness_m != repeated.spaciousness_m)
    return "another scan";
  return nullptr;
}

}  // namespace headframe
