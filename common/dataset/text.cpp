#include "common/dataset/text.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>

namespace headframe::dataset {

Result<std::string> read_file(const std::filesystem::path& path, std::uintmax_t most_bytes) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) return failure(ErrorCode::not_found, path.string() + ": no such file");
  if (!std::filesystem::is_regular_file(status)) return failure(ErrorCode::bad_input, path.string() + ": not a file");
  const auto size = std::filesystem::file_size(path, error);
  if (error) return failure(ErrorCode::unavailable, path.string() + ": cannot be read: " + error.message());
  if (size > most_bytes)
    return failure(ErrorCode::bad_input,
                   path.string() + ": " + std::to_string(size) + " bytes, the limit is " + std::to_string(most_bytes));
  std::string bytes(size, '\0');
  std::ifstream file(path, std::ios::binary);
  if (!file) return failure(ErrorCode::unavailable, path.string() + ": cannot be opened; check its permissions");
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  if (file.bad() || (size > 0 && file.gcount() == 0))
    return failure(ErrorCode::unavailable, path.string() + ": cannot be read");
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  return bytes;
}

std::optional<std::string_view> Lines::next() {
  if (at_byte_ >= text_.size()) return std::nullopt;
  const std::size_t end = std::min(text_.find('\n', at_byte_), text_.size());
  std::string_view line = text_.substr(at_byte_, end - at_byte_);
  if (line.ends_with('\r')) line.remove_suffix(1);
  at_byte_ = std::min(end + 1, text_.size());
  ++number_;
  return line;
}

std::vector<std::string_view> words(std::string_view line) {
  constexpr std::string_view blank = " \t";
  std::vector<std::string_view> out;
  std::size_t start = line.find_first_not_of(blank);
  while (start != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(blank, start), line.size());
    out.push_back(line.substr(start, end - start));
    start = line.find_first_not_of(blank, end);
  }
  return out;
}

namespace {

template <class T>
std::optional<T> whole(std::string_view word) {
  T value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<double> to_number(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);  // which from_chars does not take
  return whole<double>(word);
}

std::optional<std::uint64_t> to_count(std::string_view word) { return whole<std::uint64_t>(word); }

std::string in_quotes(std::string_view word) {
  constexpr std::size_t most = 40;
  std::string out = "'";
  for (const char c : word.substr(0, most)) out += c >= 0x20 && c < 0x7f ? c : '?';
  return out += word.size() > most ? "...'" : "'";
}

}  // namespace headframe::dataset
