#include "server/atlas/alignment.hpp"

#include <array>

namespace headframe {
namespace {

constexpr std::array<std::string_view, 6> state_names{"candidate", "provisional", "verified",
                                                      "published", "retracted",   "rejected"};

constexpr std::array<std::string_view, 5> ruling_names{"none", "confirmed", "refused", "retracted", "placed"};

}  // namespace

std::string_view to_string(AlignmentState state) { return state_names.at(static_cast<std::size_t>(state)); }

std::optional<AlignmentState> alignment_state_from(std::string_view name) {
  for (std::size_t i = 0; i < state_names.size(); ++i)
    if (state_names[i] == name) return static_cast<AlignmentState>(i);
  return std::nullopt;
}

std::string_view to_string(Ruling ruling) { return ruling_names.at(static_cast<std::size_t>(ruling)); }

}  // namespace headframe
