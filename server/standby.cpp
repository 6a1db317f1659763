#include "server/standby.hpp"

#include "common/security/secret.hpp"
#include "server/net/bind_port.hpp"
#include "server/security/operator_guard.hpp"
#include "server/security/server_identity.hpp"

namespace headframe {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> can_not(const fs::path& data, const std::string& why, const std::optional<ServerCard>& active) {
  return failure(ErrorCode::refused, "this server cannot be a standby: " + why +
                                         "; copy identity.pem, operator.token and, if it exists, operators.json from "
                                         "the data directory of " +
                                         (active ? active->name : "the active server") + " into " + data.string() +
                                         ", allow only their owner to read them, and start this server again");
}

}  // namespace

Result<ServerCard> known_by(const fs::path& data) {
  for (const char* file : {"identity.pem", "operator.token"})
    if (!fs::exists(data / file)) return failure(ErrorCode::refused, (data / file).string() + " is missing");
  const auto identity = server_identity(data, false);
  if (!identity) return tl::unexpected(identity.error());
  const auto token = operator_token(data);
  if (!token) return tl::unexpected(token.error());
  ServerCard card;
  card.fingerprint = identity->fingerprint;
  card.token_digest = sha256(*token);
  return card;
}

Result<void> fit_to_stand_by(const fs::path& data, const std::optional<ServerCard>& active) {
  const auto own = known_by(data);
  if (!own) return can_not(data, own.error().message, active);
  if (!active) return {};
  if (own->fingerprint != active->fingerprint)
    return can_not(data, "its identity.pem differs from the active server's, so robots would not accept it", active);
  if (own->token_digest != active->token_digest)
    return can_not(data, "its operator.token differs from the active server's, so operators could not sign in", active);
  return {};
}

Result<ReservedPort> ReservedPort::at(const Endpoint& endpoint) {
  ReservedPort port;
  if (const auto code = bind_port(port.socket_, endpoint)) return listen_failure(endpoint, code);
  port.endpoint_ = {endpoint.host, port.socket_.local_endpoint().port()};
  return port;
}

}  // namespace headframe
