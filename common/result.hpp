#pragma once
// Expected faults are values: every call that can fail for a reason outside the program returns a Result.

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

namespace headframe {

enum class ErrorCode {
  invalid_argument,  // the caller's own mistake: a bad option, a value out of range
  bad_input,         // a file or message whose content is wrong
  not_found,         // a file, session or component that is not there
  unavailable,       // a peer or device that does not answer, a port in use, a full disk; may pass
  refused,           // a peer or policy said no
  incompatible,      // another protocol or schema version
  internal,          // a broken invariant of our own
};

/// The stable lower-case name of a code, for logs and JSON.
std::string_view to_string(ErrorCode code);

/// What went wrong: one line that says what, where and what to do.
struct Error {
  ErrorCode code = ErrorCode::internal;
  std::string message;
};

template <class T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> failure(ErrorCode code, std::string message) {
  return tl::unexpected<Error>(Error{code, std::move(message)});
}

}  // namespace headframe
