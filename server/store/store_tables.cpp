#include "server/store/store_tables.hpp"

#include <cmath>
#include <limits>
#include <sstream>

#include "server/store/row_checksum.hpp"

namespace headframe {
namespace {

constexpr std::uint64_t rows_between_words = 1000;

struct TypedColumn {
  std::string name;
  char kind;
};

std::vector<TypedColumn> typed_columns(const StoreTable& table) {
  std::vector<TypedColumn> columns;
  std::istringstream in{std::string(table.columns)};
  for (std::string word; in >> word;) columns.push_back({word.substr(0, word.size() - 1), word.back()});
  return columns;
}

std::string joined(const std::vector<TypedColumn>& columns) {
  std::string all;
  for (const TypedColumn& column : columns) all += (all.empty() ? "" : ", ") + column.name;
  return all;
}

SqlValue value_of(const Row& row, int index, char kind) {
  if (kind == '~') return row.real(index);  // a missing number is NaN in one database and NULL in the other
  if (row.is_null(index)) return std::monostate();
  if (kind == '#') return row.integer(index);
  if (kind == '$') return row.blob(index);
  return Blob{row.blob(index)};
}

struct AddTo {
  RowChecksum& sum;
  void operator()(std::monostate) const { sum.add(std::uint64_t{0x6e756c6c}); }
  void operator()(std::int64_t value) const { sum.add(static_cast<std::uint64_t>(value)); }
  void operator()(double value) const { sum.add(std::isnan(value) ? std::numeric_limits<double>::quiet_NaN() : value); }
  void operator()(std::string_view value) const { sum.add(value); }
  void operator()(Blob value) const { sum.add(value.bytes); }
};

using TakeRow = std::function<Result<void>(const std::vector<SqlValue>&)>;

Result<TableSum> read_table(Database& database, const StoreTable& table, const TakeRow& take,
                            const TableProgress& progress) {
  const auto columns = typed_columns(table);
  const std::string from = " FROM " + std::string(table.name);
  std::uint64_t all = 0;
  auto read = database.each("SELECT count(*)" + from,
                            [&](const Row& row) { all = static_cast<std::uint64_t>(row.integer(0)); });
  if (!read) return tl::unexpected(read.error());
  progress(table.name, 0, all);
  TableSum sum;
  std::vector<SqlValue> values(columns.size());
  Result<void> taken;
  read = database.each("SELECT " + joined(columns) + from, [&](const Row& row) {
    if (!taken) return;
    RowChecksum checksum;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      values[i] = value_of(row, static_cast<int>(i), columns[i].kind);
      std::visit(AddTo{checksum}, values[i]);
    }
    sum.checksum += static_cast<std::uint64_t>(checksum.value());
    if (++sum.rows % rows_between_words == 0) progress(table.name, sum.rows, all);
    taken = take(values);
  });
  if (!read) return tl::unexpected(read.error());
  if (!taken) return tl::unexpected(taken.error());
  progress(table.name, sum.rows, all);
  return sum;
}

}  // namespace

const std::vector<StoreTable>& store_tables() {
  static const std::vector<StoreTable> tables{
      {"sessions",
       "id# robot$ session$ sensor_model$ beams# fov_up_deg~ fov_down_deg~ max_range_m~ family$ family_version# "
       "q_size# "
       "w_size# spool_id# complete# attempted_keyframes# spool_run# label$ attempted_whole# note$ "
       "archived# site$ pose_update#"},
      {"keyframes",
       "session# sequence# stamp_s~ T_local_sensor& spaciousness_m~ q& w& place_class# walls& point_count# checksum#"},
      {"moved_poses", "session# sequence# T_local_sensor& checksum#"},
      {"pose_updates", "session# sequence# number# keyframes# T_local_sensor& checksum#"},
      {"clouds", "session# sequence# encoded&"},
      {"alignments", "a# b# id# state$ T_a_b& verdict$ T_a_b_runner_up&"},
      {"evidence", "a# b# name$ value~"},
      {"revisions", "number# time_s~"},
      {"placements", "revision# session# component# T_component_session&"},
      {"placed", "session# component# T_component_session&"},
      {"merge_order", "step# revision# a# b# state$"},
      {"decisions", "id# alignment# decision$ T_a_b& seen_points~ time_s~ undone#"},
      {"robots", "name$ token_digest& code_digest& code_expires_s~ enrolled_s~ revoked# rate_kib_s#"},
      {"robot_sites", "robot$ site$"},
      {"anchors", "session# choice#"},
      {"surveys", "session# choice# T_grid_session&"},
      {"survey_points", "session# number# name$ x_session_m~ y_session_m~ z_session_m~ x_grid_m~ y_grid_m~ z_grid_m~"},
      {"troubles", "session# deaths# kills# why_aside$ deleted#"},
      {"self_likeness", "session# path_m~ clouds# aliases~ look_alikes~ wanted& similar_places~ places&"},
      {"loop_closures", "a# b# places&"},
      {"let_go", "session# sequence#"},
      {"frozen", "session# frame# T_frame_session& places&"},
      {"changes",
       "a# b# number# kind$ x_a_m~ y_a_m~ z_a_m~ length_m~ width_m~ height_m~ a_is_newer# older_s~ newer_s~"},
  };
  return tables;
}

std::vector<std::string> column_names(const StoreTable& table) {
  std::vector<std::string> names;
  for (TypedColumn& column : typed_columns(table)) names.push_back(std::move(column.name));
  return names;
}

Result<TableSums> sum_tables(Database& database, const TableProgress& progress) {
  TableSums sums;
  for (const StoreTable& table : store_tables()) {
    const auto sum = read_table(
        database, table, [](const auto&) { return Result<void>(); }, progress);
    if (!sum) return tl::unexpected(sum.error());
    sums[std::string(table.name)] = *sum;
  }
  return sums;
}

Result<TableSums> copy_tables(Database& from, Database& to, const TableProgress& progress) {
  TableSums sums;
  for (const StoreTable& table : store_tables()) {
    const auto columns = typed_columns(table);
    std::string marks = "?";
    for (std::size_t i = 1; i < columns.size(); ++i) marks += ",?";
    const std::string insert =
        "INSERT INTO " + std::string(table.name) + " (" + joined(columns) + ") VALUES (" + marks + ")";
    const auto sum = read_table(
        from, table, [&](const auto& values) { return to.change(insert, values, {}); }, progress);
    if (!sum) return tl::unexpected(sum.error());
    if (auto settled = to.settle(); !settled) return tl::unexpected(settled.error());
    sums[std::string(table.name)] = *sum;
  }
  return sums;
}

}  // namespace headframe
