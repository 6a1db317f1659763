#include "tests/bench/rejudge.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>

#include "server/verification/verdict.hpp"
#include "server/verification/verification.hpp"
#include "tests/bench/verdict_rows.hpp"

namespace headframe::bench {
namespace {

using Cells = std::vector<std::string>;

struct Row {
  RowName name;
  RegistrationStatus status{};
  Evidence evidence;
};

struct Accepted {
  int right = 0, wrong = 0;
  void add(bool is_right) { ++(is_right ? right : wrong); }
};

struct VerdictCounts {
  Accepted all, before, now;
};

Cells cells_of(const std::string& line) {
  Cells cells;
  std::stringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  return cells;
}

RegistrationStatus status_of(const std::string& name) {
  for (const auto status :
       {RegistrationStatus::converged, RegistrationStatus::degenerate, RegistrationStatus::too_little_overlap})
    if (to_string(status) == name) return status;
  return RegistrationStatus::not_converged;
}

double number_of(const std::string& cell) {
  char* end = nullptr;
  const double value = std::strtod(cell.c_str(), &end);
  if (cell.empty() || *end != '\0') throw std::invalid_argument("'" + cell + "' is no number");
  return value;
}

/// Which column holds what; throws if one is missing.
struct Columns {
  Columns(const Cells& head, const std::string& file) {
    const auto column = [&](std::string_view name) {
      const auto at = std::ranges::find(head, name);
      if (at == head.end())
        throw std::runtime_error(
            file + " has no column " + std::string(name) +
            ": it is no verdict*.csv of stages, merges, recordings or drawn-mines, or of another version");
      return static_cast<std::size_t>(at - head.begin());
    };
    source = column("source"), mine = column("mine"), a = column("a"), b = column("b");
    right = column("right"), status = column("status"), kind = column("kind");
    for (const auto& field : evidence_fields()) fields.push_back(column(field.name));
  }
  Row row(const Cells& cells) const {
    Row row{{cells[source], cells[kind], cells[mine], cells[a], cells[b], cells[right] == "1"},
            status_of(cells[status]),
            {}};
    for (std::size_t i = 0; const auto& field : evidence_fields())
      row.evidence.*field.member = number_of(cells[fields[i++]]);
    return row;
  }
  std::size_t source, kind, mine, a, b, right, status;
  std::vector<std::size_t> fields;
};

std::vector<Row> read_judged(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line)) throw std::runtime_error(file.string() + " cannot be read, or is empty");
  const Cells head = cells_of(line);
  const Columns columns(head, file.string());
  std::vector<Row> rows;
  for (int number = 2; std::getline(in, line); ++number) {
    const Cells cells = cells_of(line);
    try {
      if (cells.size() != head.size() || in.eof()) throw std::invalid_argument("it is cut short");
      if (cells[columns.source] == "judged") rows.push_back(columns.row(cells));
    } catch (const std::invalid_argument& damage) {
      throw std::runtime_error(file.string() + " is damaged in line " + std::to_string(number) + " (" + damage.what() +
                               "): run the bench again");
    }
  }
  return rows;
}

bool accepted(const Row& row, double p) {
  Evidence judged = row.evidence;
  judged.probability = p;
  return convinces(judged, {});
}

void print_changed(const Row& row, double now) {
  const Evidence& e = row.evidence;
  std::printf("  %s %s: %s %s-%s, %.0f m, %.0f descriptors %.2f, held by %.3f, %.1f look-alikes: %.3f, was %.3f\n",
              now > e.probability ? "accepted" : "waits", row.name.right ? "right" : "WRONG", row.name.mine.c_str(),
              row.name.a.c_str(), row.name.b.c_str(), e.overlap_m, e.descriptors_compared, e.descriptors_alike,
              e.weakest_hold, e.look_alikes, now, e.probability);
}

/// Of every contribution: what would be accepted besides if it never spoke against a placement, and at how many right
/// ones that wait it speaks loudest.
struct Prices {
  std::vector<Accepted> without = std::vector<Accepted>(verdict_term_count);
  std::vector<int> loudest = std::vector<int>(verdict_term_count);

  void add(const Row& row) {
    const LogOdds odds = log_odds(row.evidence);
    for (std::size_t i = 0; i < verdict_term_count; ++i) {
      const double z = odds.sum() - std::min(0.0, odds.contributions[i].value);
      if (accepted(row, 1 / (1 + std::exp(-z)))) without[i].add(row.name.right);
    }
    const auto least = std::ranges::min_element(odds.contributions, {}, &VerdictTerm::value);
    if (row.name.right) ++loudest[static_cast<std::size_t>(least - odds.contributions.begin())];
  }
  void print() const {
    std::printf("%-52s %12s %6s   %s\n", "if it never spoke against a placement, accepted too", "right", "wrong",
                "loudest at right ones that wait");
    const LogOdds names = log_odds({});
    for (std::size_t i = 0; i < verdict_term_count; ++i)
      std::printf("%-52s %12d %6d   %d\n", std::string(names.contributions[i].name).c_str(), without[i].right,
                  without[i].wrong, loudest[i]);
  }
};

}  // namespace

nlohmann::json rejudge(const std::vector<std::filesystem::path>& files, const std::filesystem::path& rejudged) {
  std::vector<Row> rows;  // all of them, before one of the files is written over
  for (const auto& file : files)
    for (Row& row : read_judged(file)) rows.push_back(std::move(row));
  std::ofstream csv(rejudged);
  write_row_head(csv);
  std::map<std::string, VerdictCounts> kinds;
  Prices prices;
  for (const Row& row : rows) {
    Judgement anew{.status = row.status, .evidence = row.evidence};
    weigh(anew);
    write_row(csv, row.name, anew.status, anew.evidence);
    const double now = anew.evidence.probability;
    const bool stood = accepted(row, row.evidence.probability), stands = accepted(row, now), right = row.name.right;
    for (const auto& key : {row.name.kind, std::string("all")}) {
      kinds[key].all.add(right);
      if (stood) kinds[key].before.add(right);
      if (stands) kinds[key].now.add(right);
    }
    if (stood != stands) print_changed(row, now);
    if (!stands && row.status == RegistrationStatus::converged) prices.add(row);
  }
  if (!csv)
    throw std::runtime_error(rejudged.string() + " cannot be written: is there a folder, and room on the disk?");
  prices.print();
  std::printf("%-16s %16s %24s %24s\n", "kind", "right, wrong", "accepted: right, wrong", "before: right, wrong");
  nlohmann::json figures;
  for (const auto& [kind, c] : kinds) {
    std::printf("%-16s %8d %7d %16d %7d %16d %7d\n", kind.c_str(), c.all.right, c.all.wrong, c.now.right, c.now.wrong,
                c.before.right, c.before.wrong);
    figures[kind] = {{"right", c.all.right},           {"wrong", c.all.wrong},
                     {"accepted_right", c.now.right},  {"accepted_wrong", c.now.wrong},
                     {"before_right", c.before.right}, {"before_wrong", c.before.wrong}};
  }
  return figures;
}

}  // namespace headframe::bench
