// Replaces network.cpp in a build without networks.
#include "common/descriptor/network.hpp"

namespace headframe {

struct Network::Runtime {};

Result<Network> Network::from_bytes(std::string_view /*onnx*/, const std::string& name) {
  return failure(ErrorCode::not_found,
                 name + ": this build has no networks; build with -DHEADFRAME_NETWORKS=ON, or use another family");
}

Result<std::vector<std::vector<float>>> Network::run(const std::vector<float>& /*image*/) const {
  return failure(ErrorCode::internal, "this build has no networks");
}

Network::Network(Network&&) noexcept = default;
Network& Network::operator=(Network&&) noexcept = default;
Network::~Network() = default;

}  // namespace headframe
