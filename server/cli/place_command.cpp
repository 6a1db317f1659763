// One session laid on another by hand.
#include <charconv>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "server/cli/commands.hpp"
#include "server/cli/table.hpp"
#include "server/cli/views.hpp"

namespace headframe {
namespace {

using Json = nlohmann::json;

/// Six numbers a line, between commas, semicolons or blanks: x, y, z in A, then in B. Lines that begin with # are
/// comments.
Result<Json> pairs_from(const std::string& path) {
  constexpr std::size_t figures = 6;
  std::ifstream file(path);
  if (!file) return failure(ErrorCode::not_found, "there is no file " + path + ", or it can not be read");
  Json pairs = Json::array();
  int number = 0;
  for (std::string line; std::getline(file, line);) {
    ++number;
    for (char& c : line) c = c == ',' || c == ';' || c == '\t' || c == '\r' ? ' ' : c;
    std::istringstream words(line);
    std::vector<double> values;
    bool sound = true;
    for (std::string word; sound && words >> word && (word.front() != '#' || !values.empty());) {
      double value = 0;
      const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
      sound = fault == std::errc() && end == word.data() + word.size();
      values.push_back(value);
    }
    if (sound && values.empty()) continue;
    if (!sound || values.size() != figures)
      return failure(ErrorCode::bad_input,
                     path + ", line " + std::to_string(number) + ": give x y z of a spot in A, then x y z of it in B");
    pairs.push_back({{"p_a", {values[0], values[1], values[2]}}, {"p_b", {values[3], values[4], values[5]}}});
  }
  return Json{{"pairs", std::move(pairs)}};
}

std::string placed_view(const Json& placed) {
  const Json& explanation = placed.at("explanation");
  const Json& alignment = explanation.at("alignment");
  constexpr double far_m = 5, far_deg = 25;
  const bool registered = placed.at("moved_m").is_number();
  const double moved_m = registered ? placed.at("moved_m").get<double>() : 0;
  const double turned_deg = registered ? placed.at("turned_deg").get<double>() : 0;
  const std::string moved =
      "registration moved it by " + fixed(moved_m, 2) + " m and " + fixed(turned_deg, 1) + " deg\n";
  const std::string id = alignment.at("id").dump();
  const std::string kept =
      placed.at("recorded").get<bool>() ? moved + "alignment " + id + " waits for you: headframe confirm " + id +
                                              " merges the two, headframe undo " + id + " forgets it\n"
      : moved_m > far_m || turned_deg > far_deg
          ? moved + "not kept: that is another placement than yours; lay it nearer if it is right\n"
          : "not kept: it does not fit where you put it\n";
  return kept + explanation_view(explanation);
}

}  // namespace

Result<int> Commands::place(const std::string& a, const std::string& b, const std::vector<double>& at,
                            const std::string& file) {
  if (at.empty() == file.empty())
    return failure(ErrorCode::invalid_argument, "say where B lies on A: --at X Y Z YAW, or --pairs FILE");
  Result<Json> body = Json{{"at", at}};
  if (!file.empty()) body = pairs_from(file);
  if (!body) return tl::unexpected(body.error());
  const auto row_a = session_named(a), row_b = session_named(b);
  if (!row_a) return tl::unexpected(row_a.error());
  if (!row_b) return tl::unexpected(row_b.error());
  const auto full = [](const Json& row) {
    return percent_encoded(row.at("robot").get<std::string>() + "/" + row.at("session").get<std::string>());
  };
  const auto answer = posted("/api/v1/place?a=" + full(*row_a) + "&b=" + full(*row_b), 200, body->dump());
  auto shown = printed(answer, placed_view);
  if (!shown) return shown;
  return Json::parse(*answer).at("recorded").get<bool>() ? exit_ok : exit_failed;
}

}  // namespace headframe
