#include "common/descriptor/family.hpp"

#include "common/descriptor/scan_context.hpp"

namespace headframe {

Result<std::unique_ptr<DescriptorFamily>> make_family(std::string_view name) {
  if (name == "scan_context") return std::make_unique<ScanContext>();
  return failure(ErrorCode::not_found, "no descriptor family '" + std::string(name) + "'; there is: scan_context");
}

}  // namespace headframe
