#pragma once
// The robot's identity and connection settings, from its configuration.

#include <optional>

#include "client/credential/credential_file.hpp"
#include "client/robot_client.hpp"
#include "client/uplink/uplink.hpp"
#include "common/wire/convert.hpp"

namespace headframe {

/// The hello message, without the token. family: that of add_scan; null with own descriptors.
Hello hello_of(const RobotConfig& config, const DescriptorFamily* family);

/// The server's address and how to authenticate it. credential: is opened here, unless the configuration says insecure.
/// Fails like CredentialFile::open(), and with invalid_argument if the fingerprint is malformed.
Result<UplinkConfig> link_of(const RobotConfig& config, std::optional<CredentialFile>& credential);

}  // namespace headframe
