#include "client/uplink/localization_message.hpp"

#include <algorithm>
#include <cmath>

#include "common/printable.hpp"
#include "common/wire/convert.hpp"

namespace headframe {
namespace {

constexpr std::size_t most_missing_bytes = 1024;

/// Where it was found.
Result<void> read_place(const v1::Localization& message, Localization& out) {
  const auto anchor = from_proto(message.anchor()), session = from_proto(message.session());
  const auto T_session = from_proto(message.t_component_session()), T_sensor = from_proto(message.t_component_sensor());
  if (!anchor) return tl::unexpected(anchor.error());
  if (!session) return tl::unexpected(session.error());
  if (!T_session) return tl::unexpected(T_session.error());
  if (!T_sensor) return tl::unexpected(T_sensor.error());
  out.component = message.component();
  out.anchor = *anchor;
  out.session = *session;
  out.T_component_session = *T_session;
  out.T_component_sensor = *T_sensor;
  if (message.covariance_size() != static_cast<int>(out.covariance.size()))
    return failure(ErrorCode::bad_input, "a covariance without 36 numbers");
  for (int i = 0; i < message.covariance_size(); ++i) out.covariance(i / 6, i % 6) = message.covariance(i);
  if (!out.covariance.allFinite()) return failure(ErrorCode::bad_input, "a covariance that is not finite");
  return {};
}

}  // namespace

Result<Localization> localization_from(const v1::Localization& message) {
  Localization out;
  out.keyframe = message.keyframe();
  out.merged = message.merged();
  out.probability = message.probability();
  out.shared_m = message.shared_m();
  out.awaited_m = message.awaited_m();
  out.look_alikes = message.look_alikes();
  for (const double number : {out.probability, out.shared_m, out.awaited_m, out.look_alikes})
    if (!std::isfinite(number)) return failure(ErrorCode::bad_input, "a number is not finite");
  out.missing = printable(std::string_view(message.missing()).substr(0, most_missing_bytes));
  if (!message.found()) return out;
  out.state = Localization::State::found;
  if (auto ok = read_place(message, out); !ok) return tl::unexpected(ok.error());
  return out;
}

}  // namespace headframe
