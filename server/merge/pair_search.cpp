#include "server/merge/pair_search.hpp"

#include <gnu/libc-version.h>

#include <fstream>
#include <sstream>

#include "common/security/secret.hpp"

namespace headframe {
namespace {

void add(std::string& bytes, const void* data, std::size_t count) {
  bytes.append(static_cast<const char*>(data), count);
}

template <class Number>
void add(std::string& bytes, const Number& number) {
  add(bytes, &number, sizeof number);
}

void add(std::string& bytes, const std::vector<float>& numbers) {
  add(bytes, numbers.size());
  add(bytes, numbers.data(), numbers.size() * sizeof(float));
}

/// A digest of the running program; if it cannot be read, one that no other program has.
const std::string& program() {
  static const std::string digest = [] {
    std::ostringstream bytes;
    bytes << std::ifstream("/proc/self/exe", std::ios::binary).rdbuf();
    return bytes.view().empty() ? random_secret(32) : sha256(bytes.view());
  }();
  return digest;
}

/// The C library chooses by it how to compute sines and the like.
std::string processor() {
  std::string out;
#if defined(__x86_64__)
  __builtin_cpu_init();
  out += __builtin_cpu_supports("fma") ? "fma " : "";
  out += __builtin_cpu_supports("fma4") ? "fma4 " : "";
  out += __builtin_cpu_supports("avx2") ? "avx2 " : "";
  out += __builtin_cpu_supports("avx512f") ? "avx512f " : "";
#endif
  return out;
}

}  // namespace

std::string computed_by(const MergeConfig& config) {
  std::ostringstream out;
  out << program() << ' ' << gnu_get_libc_version() << ' ' << processor() << static_cast<int>(config.registration)
      << ' ' << config.placements << ' ' << config.hypotheses << ' ' << config.wall_search.cell_m << ' '
      << config.wall_search.quarter_turns << ' ' << config.wall_search.peaks << ' ' << config.wall_search.penalty;
  return out.str();
}

HypothesisFinder::Config finder_config(const MergeConfig& config) {
  return {.seats = {.coherent = static_cast<std::size_t>(config.hypotheses),
                    .coarse_matches = static_cast<std::size_t>(config.placements),
                    .steps = config.wall_search},
          .walls_bytes = 1000000 * static_cast<std::size_t>(config.walls_mb),
          .threads = config.threads};
}

SessionView PairSearch::view(SessionId id, const Session& session) {
  return {id, session.keyframes, session.complete, session.family, session.asks_where};
}

std::string PairSearch::digest(SessionId id, const CloudSource& clouds) const {
  const Session& session = sessions_.at(id);
  std::string bytes = computed_by(config_) + '\0' + session.family.name + '\0';
  add(bytes, session.family.version);
  for (const Keyframe& k : session.keyframes) {
    add(bytes, k.sequence);
    add(bytes, k.stamp_s);
    add(bytes, k.T_local_sensor.matrix().data(), 16 * sizeof(double));
    add(bytes, k.spaciousness_m);
    add(bytes, k.descriptor.q);
    add(bytes, k.descriptor.w);
    add(bytes, k.descriptor.place_class);
    add(bytes, k.walls.code.data(), k.walls.code.size());
    add(bytes, k.point_count);
    add(bytes, clouds.state({id, k.sequence}) == CloudState::stored);
  }
  return sha256(bytes);
}

PairFindings PairSearch::find(SessionId a, SessionId b, CloudSource& clouds) {
  PairFindings out;
  if (a == b) {
    out.itself = self_.search(a, clouds);
    return out;
  }
  const OrderedPair pair{a, b};
  out.hypotheses = finder_.search_apart(view(a, sessions_.at(a)), view(b, sessions_.at(b)));
  std::vector<Case> cases;
  cases.reserve(out.hypotheses.size());
  for (const Hypothesis& h : out.hypotheses) cases.push_back(requests_.make_case(a, b, h, clouds));
  const std::vector<ScreeningResult> screened = screen(pair, cases, submaps_, clouds, judge_);
  for (std::size_t i = 0; i < screened.size(); ++i)
    if (screened[i].hopeful) out.hopeful.push_back({i, screened[i].place});
  out.judged = verifier_.judge_ahead(pair, cases, screened, clouds);
  return out;
}

}  // namespace headframe
