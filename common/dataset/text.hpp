#pragma once
// Reading small text formats: whole files with a size limit, lines with their numbers, words, numbers.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace headframe::dataset {

/// The bytes of a regular file. not_found: it does not exist; bad_input: it is larger than most_bytes (checked before
/// memory is allocated); unavailable: it cannot be read. The message names the path.
Result<std::string> read_file(const std::filesystem::path& path, std::uintmax_t most_bytes);

/// The error for a file with wrong content.
inline tl::unexpected<Error> bad(std::string message) { return failure(ErrorCode::bad_input, std::move(message)); }

/// Iterates over the lines of a text. Line ends are "\n" or "\r\n" and not part of the line; the last line needs none.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}
  std::optional<std::string_view> next();
  std::size_t number() const { return number_; }    // of the line last returned by next(), from 1
  std::size_t at_byte() const { return at_byte_; }  // where the next line starts

 private:
  std::string_view text_;
  std::size_t at_byte_ = 0;
  std::size_t number_ = 0;
};

/// The parts between spaces and tabs.
std::vector<std::string_view> words(std::string_view line);

/// The whole word as a number; "nan" and "inf" are numbers. Nullopt if it is not a number.
std::optional<double> to_number(std::string_view word);

/// The whole word as a count, decimal digits only.
std::optional<std::uint64_t> to_count(std::string_view word);

/// Text of a file as it may stand in an error message: in quotes, cut when long, without control bytes.
std::string in_quotes(std::string_view word);

}  // namespace headframe::dataset
