#include "tests/bench/live/live_report.hpp"

#include <cstdio>

#include "tests/bench/measure.hpp"

namespace headframe::bench {
namespace {

nlohmann::json to_json(const Evidence& e) {
  nlohmann::json out;
  for (const EvidenceField& field : evidence_fields()) out[std::string(field.name)] = e.*field.member;
  return out;
}

nlohmann::json to_json(const Claim& c) {
  return {{"a", c.pair.first},        {"b", c.pair.second},        {"state", to_string(c.state)},
          {"at_s", c.at_s},           {"wrong", c.standing.wrong}, {"off_m", c.standing.off_m},
          {"known_a_m", c.known_a_m}, {"known_b_m", c.known_b_m},  {"evidence", to_json(c.evidence)}};
}

nlohmann::json to_json(const Stood& s) {
  return {{"a", s.pair.first},        {"b", s.pair.second},
          {"from_s", s.from_s},       {"to_s", s.to_s},
          {"path_m", s.path_m},       {"off_m", s.off_m},
          {"at_end", s.at_end},       {"known_a_m", s.known_a_m},
          {"known_b_m", s.known_b_m}, {"evidence", to_json(s.evidence)}};
}

struct LiveRow {
  std::size_t drives = 0, wrong_drives = 0, wrong = 0, wrong_at_end = 0, right_at_end = 0, withdrawn = 0, differ = 0,
              asked = 0, provisional = 0;
  int meet = 0;
  void add(const LiveDrive& d) {
    ++drives;
    wrong_drives += !d.wrong.empty();
    wrong += d.wrong.size();
    for (const Stood& s : d.wrong) wrong_at_end += s.at_end;
    for (const Stood& s : d.right) right_at_end += s.at_end;
    withdrawn += d.right_withdrawn;
    provisional += d.wrong_provisional;
    differ += !d.end_differs.empty();
    asked += !d.asking_changed.empty();
    meet += d.meet;
  }
};

void print(const std::string& name, const LiveRow& r) {
  std::printf("  %-28s %6zu %6zu %6zu %6zu %11zu %6d %6zu %9zu %7zu %6zu\n", name.c_str(), r.drives, r.wrong_drives,
              r.wrong, r.wrong_at_end, r.provisional, r.meet, r.right_at_end, r.withdrawn, r.differ, r.asked);
}

nlohmann::json to_json(const LiveRow& r) {
  return {{"drives", r.drives},
          {"wrong_drives", r.wrong_drives},
          {"wrong", r.wrong},
          {"wrong_at_end", r.wrong_at_end},
          {"meet", r.meet},
          {"right_at_end", r.right_at_end},
          {"withdrawn", r.withdrawn},
          {"ends_differ", r.differ},
          {"asking_changed", r.asked},
          {"wrong_provisional", r.provisional}};
}

}  // namespace

void print(const LiveDrive& d) {
  std::printf("%-22s %-36s %3zu attempts, %zu right at some time, %zu withdrawn, %zu wrong\n", d.set.c_str(),
              d.conditions.c_str(), d.attempts, d.right.size(), d.right_withdrawn, d.wrong.size());
  for (const Stood& s : d.wrong)
    std::printf(
        "    WRONG %s and %s: %.0f m off for %.1f s, %.0f m of path%s; known %.0f and %.0f m; p %.3f, %.0f m "
        "shared, %.0f aliases, repetition %.2f, alike %.2f, hold %.3f, violation %.4f\n",
        s.pair.first.c_str(), s.pair.second.c_str(), s.off_m, s.to_s - s.from_s, s.path_m, s.at_end ? ", STANDS" : "",
        s.known_a_m, s.known_b_m, s.evidence.probability, s.evidence.overlap_m, s.evidence.aliases,
        s.evidence.repetition, s.evidence.descriptors_alike, s.evidence.weakest_hold, s.evidence.worst_place_violation);
  for (const std::string& text : d.end_differs) std::printf("    END DIFFERS %s\n", text.c_str());
  for (const std::string& text : d.asking_changed) std::printf("    ASKING CHANGED %s\n", text.c_str());
  std::fflush(stdout);
}

nlohmann::json to_json(const LiveDrive& d) {
  nlohmann::json out{{"set", d.set},
                     {"kind", d.kind},
                     {"conditions", d.conditions},
                     {"attempts", d.attempts},
                     {"meet", d.meet},
                     {"right_withdrawn", d.right_withdrawn},
                     {"wrong_provisional", d.wrong_provisional},
                     {"later_m", d.later_m},
                     {"end_differs", d.end_differs},
                     {"asking_changed", d.asking_changed},
                     {"wrong", nlohmann::json::array()},
                     {"right", nlohmann::json::array()}};
  for (const Stood& s : d.wrong) out["wrong"].push_back(to_json(s));
  for (const Stood& s : d.right) out["right"].push_back(to_json(s));
  for (const Claim& c : d.claims) out["claims"].push_back(to_json(c));
  return out;
}

nlohmann::json summary(const std::vector<LiveDrive>& drives) {
  std::map<std::string, LiveRow> kinds, conditions;
  LiveRow all;
  std::vector<double> later_m;
  for (const LiveDrive& d : drives) {
    kinds[d.kind].add(d);
    conditions[d.conditions].add(d);
    all.add(d);
    later_m.insert(later_m.end(), d.later_m.begin(), d.later_m.end());
  }
  std::printf("  %-28s %6s %6s %6s %6s %11s %6s %6s %9s %7s %6s\n", "", "drives", "wrong", "merges", "at end",
              "provisional", "meet", "merged", "withdrawn", "differ", "asked");
  for (const auto& [name, row] : kinds) print(name, row);
  for (const auto& [name, row] : conditions) print(name, row);
  print("all", all);
  nlohmann::json out = to_json(all);
  out["wrong_ever"] = all.wrong;
  for (const auto& [name, row] : kinds) out["kinds"][name] = to_json(row);
  for (const auto& [name, row] : conditions) out["conditions"][name] = to_json(row);
  out["later_m_p50"] = quantile(later_m, 0.5);
  out["later_m_p95"] = quantile(later_m, 0.95);
  if (!later_m.empty())
    std::printf("  right merges waited for %.0f m (p50), %.0f m (p95) of path; %zu of them\n", quantile(later_m, 0.5),
                quantile(later_m, 0.95), later_m.size());
  return out;
}

}  // namespace headframe::bench
