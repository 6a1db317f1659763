#include "server/operator/event_log.hpp"

#include <chrono>
#include <optional>

#include "server/operator/json_text.hpp"

namespace headframe {
namespace {

Json entry_object(const LogEntry& entry) {
  return {{"id", entry.id},
          {"at_s", entry.at_s},
          {"kind", entry.kind},
          {"text", entry.text},
          {"by", entry.by.empty() ? Json() : Json(entry.by)},
          {"session_id", entry.session == 0 ? Json() : Json(entry.session)},
          {"alignment_id", entry.alignment == 0 ? Json() : Json(entry.alignment)}};
}

std::optional<LogEntry> entry_of(const std::string& line) {
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object()) return std::nullopt;
  const auto number = [&](const char* name) {  // 0 is not a valid id
    return json.contains(name) && json[name].is_number_unsigned() ? json[name].get<std::uint64_t>() : 0;
  };
  const auto words = [&](const char* name) {
    return json.contains(name) && json[name].is_string() ? json[name].get<std::string>() : std::string();
  };
  LogEntry entry{words("kind"),
                 words("text"),
                 static_cast<SessionId>(number("session_id")),
                 static_cast<AlignmentId>(number("alignment_id")),
                 words("by"),
                 number("id"),
                 json.contains("at_s") && json["at_s"].is_number() ? json["at_s"].get<double>() : 0};
  constexpr std::uint64_t most_id = 1ULL << 53U;  // JSON readers represent larger integers inexactly
  if (entry.kind.empty() || entry.id == 0 || entry.id > most_id) return std::nullopt;
  return entry;
}

double now_s() { return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count(); }

}  // namespace

EventLog::EventLog(std::filesystem::path file, const EventLogLimits& limits) : file_(std::move(file)), limits_(limits) {
  if (file_.empty()) return;
  read();
  out_.open(file_, std::ios::binary | std::ios::app);
}

void EventLog::read() {
  std::ifstream in(file_, std::ios::binary);
  for (std::string line; std::getline(in, line);) {
    written_bytes_ += line.size() + 1;
    auto entry = entry_of(line);
    if (!entry || entry->id <= newest_) continue;
    newest_ = entry->id;
    entries_.push_back(std::move(*entry));
    if (entries_.size() > limits_.entries) entries_.pop_front();
  }
  if (written_bytes_ > 0 && in.eof()) {  // ends a line that a crash cut off
    std::ifstream end(file_, std::ios::binary | std::ios::ate);
    end.seekg(-1, std::ios::end);
    if (end.get() != '\n') std::ofstream(file_, std::ios::binary | std::ios::app) << '\n';
  }
}

void EventLog::add(LogEntry entry) {
  const std::lock_guard lock(mutex_);
  entry.id = ++newest_;
  entry.at_s = now_s();
  entries_.push_back(std::move(entry));
  if (entries_.size() > limits_.entries) entries_.pop_front();
  if (file_.empty()) return;
  const std::string line = text(entry_object(entries_.back()));
  out_ << line << std::flush;
  if (!out_) {  // for example a full disk: the next entry tries again
    out_.clear();
    return;
  }
  written_bytes_ += line.size();
  if (written_bytes_ > limits_.file_bytes) begin_anew();
}

/// Rewrites the file with the entries in memory. The old file stays until the new one is complete. Call with the lock
/// held.
void EventLog::begin_anew() {
  const std::filesystem::path part = file_.string() + ".part";
  std::string all;
  for (const LogEntry& entry : entries_) all += text(entry_object(entry));
  std::error_code code;
  if (std::ofstream(part, std::ios::binary | std::ios::trunc) << all << std::flush)
    std::filesystem::rename(part, file_, code);
  out_.close();
  out_.open(file_, std::ios::binary | std::ios::app);
  written_bytes_ = all.size();
}

std::vector<LogEntry> EventLog::latest(std::size_t most) const {
  const std::lock_guard lock(mutex_);
  const std::size_t count = std::min(most, entries_.size());
  return {entries_.end() - static_cast<std::ptrdiff_t>(count), entries_.end()};
}

std::vector<LogEntry> EventLog::since(std::uint64_t id) const {
  const std::lock_guard lock(mutex_);
  std::vector<LogEntry> out;
  for (const LogEntry& entry : entries_)
    if (entry.id > id) out.push_back(entry);
  return out;
}

std::uint64_t EventLog::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

std::string log_json(const std::vector<LogEntry>& entries) {
  Json rows = Json::array();
  for (const LogEntry& entry : entries) rows.push_back(entry_object(entry));
  return text({{"entries", std::move(rows)}});
}

std::string log_event(const LogEntry& entry) { return text({{"type", "log"}, {"entry", entry_object(entry)}}); }

}  // namespace headframe
