#include "tests/bench/descriptors/costs.hpp"

#include <algorithm>
#include <ctime>
#include <random>

#include "common/descriptor/level.hpp"
#include "server/place/descriptor_index.hpp"
#include "tests/bench/measure.hpp"

namespace headframe::bench {
namespace {

constexpr std::size_t database_size = 2840, queries = 1701, asked = 20;  // as many as the paper compares
constexpr int runs = 15;

double process_ms() { return 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

std::vector<std::vector<float>> random_places(std::size_t count, std::size_t q_size, std::size_t used, unsigned seed) {
  std::mt19937 rng(seed);
  std::normal_distribution<float> value;
  std::vector<std::vector<float>> out(count, std::vector<float>(q_size));
  for (auto& q : out) std::generate_n(q.begin(), used, [&] { return value(rng); });
  return out;
}

}  // namespace

ExtractTimes time_extraction(const DescriptorFamily& family, const mine::Recording& recording) {
  std::vector<double> wall, cpu, points;
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const Points& scan = recording.scans[i].points;
    const Pose& T_local_sensor = recording.drive.T_local_sensor[i];
    const double cpu_before = process_ms();
    const double ms = wall_ms([&] { (void)family.extract(level(T_local_sensor, scan)); });
    if (i == 0) continue;  // what is made once, at the first scan
    wall.push_back(ms);
    cpu.push_back(process_ms() - cpu_before);
    points.push_back(static_cast<double>(scan.size()));
  }
  return {quantile(wall, 0.5), quantile(wall, 0.95), quantile(cpu, 0.5),
          static_cast<std::size_t>(quantile(points, 0.5))};
}

QueryTimes time_query_all(std::size_t q_size, std::size_t used) {
  const auto index = make_exact_index(q_size);
  const auto places = random_places(database_size, q_size, used, 1),
             questions = random_places(queries, q_size, used, 2);
  for (std::size_t i = 0; i < places.size(); ++i) index->add({1, i + 1}, places[i]);
  const std::vector<std::span<const float>> qs(questions.begin(), questions.end());
  std::vector<double> wall, cpu;
  for (int run = 0; run < runs; ++run) {
    wall.push_back(wall_ms([&] { index->nearest_of_each(qs, asked, 2); }));
    const double before = process_ms();
    index->nearest_of_each(qs, asked, 1);
    cpu.push_back(process_ms() - before);
  }
  return {median(wall), median(cpu)};
}

}  // namespace headframe::bench
