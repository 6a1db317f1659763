#include "client/robot_identity.hpp"

#include <utility>

#include "common/security/enrolment.hpp"
#include "common/wire/capabilities.hpp"

namespace headframe {
namespace {

Result<CredentialFile> credential_of(const RobotConfig& config) {
  const auto spool = std::filesystem::absolute(config.spool / "").parent_path();
  const auto path =
      config.credential.empty() ? spool.parent_path() / (config.robot + ".credential") : config.credential;
  return CredentialFile::open(path, config.robot, config.enrolment);
}

}  // namespace

Hello hello_of(const RobotConfig& config, const DescriptorFamily* family) {
  Hello hello;
  hello.session = {config.robot, config.session};
  hello.sensor = config.sensor;
  if (hello.sensor.model.empty()) hello.sensor.model = "unknown";
  if (config.own_descriptors)
    hello.family = {config.own_descriptors->family, config.own_descriptors->q_size, config.own_descriptors->w_size};
  else
    hello.family = {family->id(), family->q_size(), family->w_size()};
  hello.clouds = config.clouds;
  hello.software = "headframe robot library 0.1.0";
  hello.capabilities = robot_capabilities(config.provisional);
  return hello;
}

Result<UplinkConfig> link_of(const RobotConfig& config, std::optional<CredentialFile>& credential) {
  UplinkConfig link;
  link.host = config.host;
  link.port = config.port;
  link.more_servers = config.more_servers;
  link.bytes_per_s = config.bytes_per_s;
  if (config.insecure) return link;
  auto opened = credential_of(config);
  if (!opened) return tl::unexpected(opened.error());
  const auto pinned = config.fingerprint.empty() ? Result<std::string>(opened->credential().fingerprint)
                                                 : parse_fingerprint(config.fingerprint);
  if (!pinned) return tl::unexpected(pinned.error());
  link.fingerprint = *pinned;
  credential = std::move(*opened);
  return link;
}

}  // namespace headframe
