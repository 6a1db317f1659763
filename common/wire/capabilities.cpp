#include "common/wire/capabilities.hpp"

#include <algorithm>

namespace headframe {

std::vector<std::string> robot_capabilities(bool provisional) {
  std::vector<std::string> names{"cloud_refusal",
                                 "link_policy",
                                 std::string(localize_capability),
                                 std::string(poses_capability),
                                 "spares",
                                 std::string(surroundings_capability),
                                 std::string(transform_pages_capability),
                                 std::string(transform_support_capability)};
  if (provisional) names.emplace_back(provisional_capability);
  return names;
}

std::vector<std::string> server_capabilities() {
  return {"cloud_form_1",
          "cloud_form_2",
          std::string(cloud_intensity_capability),
          std::string(live_capability),
          std::string(localize_capability),
          std::string(poses_capability),
          std::string(provisional_capability),
          "spares",
          std::string(surroundings_capability),
          std::string(transform_support_capability)};
}

std::vector<std::string> usable_capabilities(const std::vector<std::string>& listed) {
  constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyz0123456789_";
  std::vector<std::string> usable(
      listed.begin(), listed.begin() + static_cast<std::ptrdiff_t>(std::min(listed.size(), most_capabilities)));
  std::erase_if(usable, [&](const std::string& name) {
    return name.empty() || name.size() > most_capability_bytes || name.find_first_not_of(letters) != std::string::npos;
  });
  return usable;
}

}  // namespace headframe
