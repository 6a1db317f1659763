#pragma once
// Who a robot is to the base station, and how it gets there, by its configuration.

#include <optional>

#include "client/credential/credential_file.hpp"
#include "client/robot_client.hpp"
#include "client/uplink/uplink.hpp"
#include "common/wire/convert.hpp"

namespace headframe {

/// What it says first, but for its token. family: of add_scan; null with own descriptors.
Hello hello_of(const RobotConfig& config, const DescriptorFamily* family);

/// Where it connects to, and whom it trusts there. credential: opened, unless the configuration says insecure. Fails as
/// CredentialFile::open() does, and with invalid_argument where the fingerprint is none.
Result<UplinkConfig> link_of(const RobotConfig& config, std::optional<CredentialFile>& credential);

}  // namespace headframe
