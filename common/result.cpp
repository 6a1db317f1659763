#include "common/result.hpp"

namespace headframe {

std::string_view to_string(ErrorCode code) {
  switch (code) {
    case ErrorCode::invalid_argument: return "invalid_argument";
    case ErrorCode::bad_input: return "bad_input";
    case ErrorCode::not_found: return "not_found";
    case ErrorCode::unavailable: return "unavailable";
    case ErrorCode::refused: return "refused";
    case ErrorCode::incompatible: return "incompatible";
    case ErrorCode::internal: break;
  }
  return "internal";
}

}  // namespace headframe
