#include "server/operator/routes.hpp"

#include <charconv>

#include "server/operator/request_target.hpp"

namespace headframe::routes {

Ready json(std::string body, int status) { return {status, "application/json", std::move(body), {}}; }

Ready file_reply(const EmbeddedFile& file) {
  return {200, std::string(file.content_type), std::string(file.bytes), {}, file.gzip};
}

Result<std::string> required(const Query& query, const std::string& name) {
  const auto found = query.find(name);
  if (found == query.end() || found->second.empty())
    return failure(ErrorCode::invalid_argument, "parameter \"" + name + "\" is missing");
  return found->second;
}

std::optional<std::int64_t> whole(const std::string& text) {
  std::int64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

Result<std::size_t> whole_number(const Query& query, const char* name, double otherwise, double most) {
  const auto found = query.find(name);
  if (found == query.end()) return static_cast<std::size_t>(otherwise);
  return parse_number(name, found->second, 0, most).map([](double value) { return static_cast<std::size_t>(value); });
}

Result<SessionRow> session_in_path(const Query& query, const Context& context) {
  return session_with(query.at("id"), context);
}

Result<SessionRow> session_with(const std::string& text, const Context& context) {
  if (const auto id = whole(text))
    for (SessionRow& row : context.station.sessions())
      if (row.id == *id) return std::move(row);
  return failure(ErrorCode::not_found, "there is no session " + text + "; the list of sessions has those there are");
}

Result<AlignmentId> alignment_named(const Query& query) {
  const std::string& text = query.at("id");
  if (const auto id = whole(text)) return *id;
  return failure(ErrorCode::invalid_argument,
                 "\"" + text + "\" is no alignment; give its number, as the list of alignments has it");
}

}  // namespace headframe::routes
