// Sweeps and the code of a cloud, in all forms; what is refused.
#include <zstd.h>

#include <algorithm>
#include <random>

#include "client/keyframe/sweeps.hpp"
#include "common/cloud/cloud_codec.hpp"
#include "common/cloud/morton.hpp"
#include "common/cloud/varint.hpp"
#include "common/security/secret.hpp"
#include "tests/vectors/vectors.hpp"

namespace headframe::vectors {
namespace {

std::string content_of(const std::string& encoded) {
  std::string content(ZSTD_getFrameContentSize(encoded.data(), encoded.size()), '\0');
  const auto n = ZSTD_decompress(content.data(), content.size(), encoded.data(), encoded.size());
  if (n != content.size()) throw std::logic_error("a cloud of ours that is no zstd frame");
  return content;
}

/// As the protocol page says: one frame of raw blocks.
std::string raw_frame(const std::string& content) {
  std::string out("\x28\xb5\x2f\xfd\xa0", 5);
  const auto put = [&](std::size_t v, int bytes) {
    for (int i = 0; i < bytes; ++i) out.push_back(static_cast<char>(v >> 8 * i));
  };
  put(content.size(), 4);
  constexpr std::size_t most = 131072;
  for (std::size_t at = 0; at < content.size(); at += most) {
    const auto block = content.substr(at, most);
    put(block.size() << 3U | (at + most >= content.size() ? 1U : 0U), 3);
    out += block;
  }
  return out;
}

/// The product writes form 1 only where form 2 is slow to read, and reads it always.
std::string as_form_1(const KeyframeCloud& cloud, float cell_m) {
  std::string out;
  put_varint(out, 1);
  put_float32(out, cell_m);
  put_varint(out, cloud.sweeps.size());
  for (const Sweep& sweep : cloud.sweeps) {
    const auto cell = [&](float metres) {
      return std::llround(static_cast<double>(metres) / static_cast<double>(cell_m));
    };
    for (int i = 0; i < 3; ++i) put_signed(out, cell(sweep.origin[i]));
    put_varint(out, sweep.points.size());
    if (sweep.points.empty()) continue;
    Eigen::Vector3f low = sweep.points.front();
    for (const auto& p : sweep.points) low = low.cwiseMin(p);
    for (int i = 0; i < 3; ++i) put_signed(out, cell(low[i]));
    std::vector<std::uint64_t> codes;
    for (const auto& p : sweep.points) {
      std::array<std::uint64_t, 3> offset{};
      for (int i = 0; i < 3; ++i)
        offset[static_cast<std::size_t>(i)] = static_cast<std::uint64_t>(cell(p[i]) - cell(low[i]));
      codes.push_back(morton::code(offset));
    }
    std::sort(codes.begin(), codes.end());
    std::uint64_t last = 0;
    for (const auto code : codes) put_varint(out, code - std::exchange(last, code));
  }
  return out;
}

/// What a reader gets: cells, in order.
Json cells_of(const KeyframeCloud& cloud, float cell_m) {
  Json sweeps = Json::array();
  for (const Sweep& sweep : cloud.sweeps) {
    Json points = Json::array();
    for (const auto& p : sweep.points) {
      const Eigen::Vector3d c = p.cast<double>() / static_cast<double>(cell_m);
      points.push_back({std::llround(c.x()), std::llround(c.y()), std::llround(c.z())});
    }
    sweeps.push_back(points);
  }
  return sweeps;
}

Json row_of(const std::string& what, const KeyframeCloud& cloud, float cell_m, bool whole = true) {
  const auto encoded = encode_cloud(cloud, cell_m).value();
  const std::string written = content_of(encoded), form_1 = as_form_1(cloud, cell_m);
  const auto read = decode_cloud(encoded).value(), read_1 = decode_cloud(raw_frame(form_1)).value();
  if (cells_of(read, cell_m) != cells_of(read_1, cell_m)) throw std::logic_error("the two forms say different things");
  Json sweeps = Json::array();
  for (const Sweep& sweep : cloud.sweeps)
    sweeps.push_back({{"origin", to_json(Points{sweep.origin})[0]}, {"points", to_json(sweep.points)}});
  Json row{{"what", what},
           {"cell_m", cell_m == 0.01F ? 0.01 : 0.05},
           {"form_1", to_hex(form_1)},
           {written.front() == 2 ? "form_2" : "written_as_form_1", to_hex(written)}};
  if (whole) row["zstd_raw_blocks"] = to_hex(raw_frame(written));
  row.update({{"sweeps", sweeps}, {"cells_read", cells_of(read, cell_m)}});
  return row;
}

Json intensity_row(const std::string& what, const KeyframeCloud& cloud) {
  const auto encoded = encode_cloud(cloud, 0.01F).value();
  const auto read = decode_cloud(encoded).value();
  Json sweeps = Json::array(), values = Json::array();
  for (const Sweep& sweep : cloud.sweeps)
    sweeps.push_back({{"origin", to_json(Points{sweep.origin})[0]},
                      {"points", to_json(sweep.points)},
                      {"intensity", sweep.intensity}});
  for (const Sweep& sweep : read.sweeps) values.push_back(sweep.intensity);
  return {{"what", what},
          {"cell_m", 0.01},
          {"form_3", to_hex(content_of(encoded))},
          {"without", to_hex(content_of(without_intensity(encoded).value()))},
          {"sweeps", sweeps},
          {"cells_read", cells_of(read, 0.01F)},
          {"intensity_read", values}};
}

/// No coordinate half-way between two cells, where 32 and 64 bits may round to different sides.
Points even(Points points) {
  for (auto& p : points)
    for (float& c : p.reshaped()) c = static_cast<float>(std::round(static_cast<double>(c) * 500) / 500);
  return points;
}

Points scattered(std::size_t count, double spread_m) {
  std::mt19937 rng(7);
  const auto coordinate = [&] { return static_cast<float>(rng() / 4294967296.0 * spread_m); };
  Points points;
  for (std::size_t i = 0; i < count; ++i) points.emplace_back(coordinate(), -coordinate(), coordinate());
  return even(points);
}

Json codes() {
  const Points asymmetric{{0, 0, 0}, {0.01F, 0, 0}, {0, 0.01F, 0}, {0, 0, 0.01F}, {0.07F, 0.02F, 0.05F}};
  Points twice = asymmetric;
  twice.push_back(twice.back());
  Json rows = Json::array();
  rows.push_back(row_of("no sweep", {}, 0.01F));
  rows.push_back(row_of("an empty sweep and one point",
                        {{Sweep{{1, -2, 0.5F}, {}}, Sweep{{0, 0, 0}, {{-1.234F, 5.678F, -0.009F}}}}}, 0.01F));
  rows.push_back(row_of("which axis is which bit", {{Sweep{{0, 0, 0}, asymmetric}}}, 0.01F));
  rows.push_back(row_of("a point twice", {{Sweep{{0, 0, 0}, twice}}}, 0.01F));
  rows.push_back(row_of("one place 40 times: form 1 is written", {{Sweep{{0, 0, 0}, Points(40, {1, 2, 3})}}}, 0.01F));
  rows.push_back(row_of("two sweeps share what was learned",
                        {{Sweep{{-1.5F, 0.25F, 0}, scattered(60, 3)}, Sweep{{0, 0, 0}, even(room_scan(36, 4))}}}, 0.01F,
                        false));
  rows.push_back(row_of("coarse cells", {{Sweep{{0, 0, 0}, scattered(80, 1)}}}, 0.05F, false));
  return rows;
}

Json with_intensity() {
  const Points asymmetric{{0, 0, 0}, {0.01F, 0, 0}, {0, 0.01F, 0}, {0, 0, 0.01F}, {0.07F, 0.02F, 0.05F}};
  const Intensities some{0, 255, 1, 128, 17};
  Intensities rising, noise;
  for (int i = 0; i < 80; ++i) rising.push_back(static_cast<std::uint8_t>(3 * i));
  std::mt19937 rng(8);
  const Points room = even(room_scan(36, 4));
  for (std::size_t i = 0; i < room.size(); ++i) noise.push_back(static_cast<std::uint8_t>(rng() >> 24U));
  Json rows = Json::array();
  rows.push_back(intensity_row("five points", {{Sweep{{0, 0, 0}, asymmetric, some}}}));
  rows.push_back(
      intensity_row("points in one cell: the faintest first; its cloud is of form 1",
                    {{Sweep{{0, 0, 0}, Points(12, {1, 2, 3}), {9, 200, 9, 0, 77, 3, 3, 3, 255, 8, 40, 41}}}}));
  rows.push_back(intensity_row("sweeps with and without share what was learned",
                               {{Sweep{{-1.5F, 0.25F, 0}, scattered(80, 3), rising}, Sweep{{1, 1, 1}, {}, {}},
                                 Sweep{{0, 0, 1}, asymmetric, {}}, Sweep{{0, 0, 0}, room, noise}}}));
  return rows;
}

Json refused() {
  const std::string good = as_form_1({{Sweep{{0, 0, 0}, {{1, 2, 3}, {2, 3, 4}}}}}, 0.01F);
  std::string form = good, sweeps = good, points = good, cell = good;
  form[0] = 4;
  sweeps.replace(5, 1, "\x81\x02");  // 257
  points[9] = 3;
  cell.replace(1, 4, std::string("\x00\x00\x30\x41", 4));  // 11 m
  const std::string bright =
      content_of(encode_cloud({{Sweep{{0, 0, 0}, {{1, 2, 3}, {2, 3, 4}}, {90, 100}}}}, 0.01F).value());
  std::string longer = bright;
  ++longer[1];
  const std::vector<std::pair<std::string, std::string>> bytes{
      {"no zstd frame", "a cloud"},
      {"bytes behind the frame", raw_frame(good) + "x"},
      {"cut short", raw_frame(good).substr(0, good.size())},
      {"form 4", raw_frame(form)},
      {"257 sweeps", raw_frame(sweeps)},
      {"more points than there are", raw_frame(points)},
      {"bytes behind the points", raw_frame(good + "x")},
      {"cells of 11 m", raw_frame(cell)},
      {"bytes behind the intensities", raw_frame(bright + "x")},
      {"intensities cut short", raw_frame(bright.substr(0, bright.size() - 1))},
      {"a longer cloud than there is before the intensities", raw_frame(longer)},
      {"intensities of a cloud with intensities",
       raw_frame("\x03" + std::string(1, static_cast<char>(bright.size())) + bright)}};
  if (!decode_cloud(raw_frame(good))) throw std::logic_error("the cloud that is spoilt is none");
  Json rows = Json::array();
  for (const auto& [what, encoded] : bytes) {
    const auto read = decode_cloud(encoded);
    if (read) throw std::logic_error(what + " is no longer refused");
    rows.push_back({{"what", what}, {"encoded", to_hex(encoded)}});
  }
  return rows;
}

File sweeps() {
  Json scans = Json::array();
  SweepCollector collector;
  const Points scan = room_scan(24, 2);
  const std::vector<double> xs{0, 0.5, 1, 1.7, 2, 2.6, 3};
  KeyframeCloud cloud;
  for (const double x : xs) {
    const Pose T = pose_from_yaw(0.1 * x, {x, 0, 0});
    const bool keyframe = x == 0 || x == 3;
    if (keyframe)
      cloud = collector.take(T, scan);
    else
      collector.add(T, scan);
    scans.push_back({{"T_local_sensor", to_json(T)}, {"keyframe", keyframe}});
  }
  Json out = Json::array();
  for (const Sweep& sweep : cloud.sweeps) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& p : sweep.points) sum += p.cast<double>();
    out.push_back({{"origin", {sweep.origin.x(), sweep.origin.y(), sweep.origin.z()}},
                   {"points", sweep.points.size()},
                   {"sum_of_points", {sum.x(), sum.y(), sum.z()}}});
  }
  return {"sweeps", {{"every_scan", to_json(scan)}, {"scans", scans}, {"cloud_of_the_second_keyframe", out}}};
}

}  // namespace

std::vector<File> cloud_files() {
  return {sweeps(), {"clouds", {{"clouds", codes()}, {"with_intensity", with_intensity()}, {"refused", refused()}}}};
}

}  // namespace headframe::vectors
