#pragma once
// Expected faults are values: every call that can fail for an external reason returns a Result.

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

namespace headframe {

enum class ErrorCode {
  invalid_argument,  // a mistake of the caller: a bad option, a value out of range
  bad_input,         // a file or message whose content is wrong
  not_found,         // a file, session or component that does not exist
  unavailable,       // a peer or device that does not respond, a port in use, a full disk; may be temporary
  refused,           // a peer or a rule refused it
  incompatible,      // another protocol or schema version
  internal,          // a broken invariant of this program
};

/// The stable lower-case name of a code, for logs and JSON.
std::string_view to_string(ErrorCode code);

/// One line that says what went wrong, where, and what to do.
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
