#include <algorithm>
#include <cmath>

#include "common/printable.hpp"
#include "common/wire/convert.hpp"
#include "common/wire/limits.hpp"

namespace headframe {
namespace {

/// Cut so that it stays valid UTF-8.
std::string cut(std::string text, std::size_t most) {
  constexpr unsigned kind = 0xc0, continues = 0x80;
  if (text.size() <= most) return text;
  while (most > 0 && (static_cast<unsigned char>(text[most]) & kind) == continues) --most;
  return text.substr(0, most);
}

}  // namespace

v1::LiveState to_proto(const LiveState& state) {
  v1::LiveState m;
  m.set_stamp_s(state.stamp_s);
  if (state.T_local_sensor) *m.mutable_t_local_sensor() = to_proto(*state.T_local_sensor);
  if (state.battery) m.set_battery(static_cast<float>(*state.battery));
  m.set_health(cut(printable(state.health), limits::health_bytes));
  return m;
}

Result<LiveState> from_proto(const v1::LiveState& m) {
  LiveState state;
  if (!std::isfinite(m.stamp_s())) return failure(ErrorCode::bad_input, "a stamp that is not finite");
  state.stamp_s = m.stamp_s();
  if (m.has_t_local_sensor()) {
    const auto T = from_proto(m.t_local_sensor());
    if (!T) return tl::unexpected(T.error());
    state.T_local_sensor = *T;
  }
  if (m.has_battery()) {
    if (!(m.battery() >= 0 && m.battery() <= 1))
      return failure(ErrorCode::bad_input, "battery: " + std::to_string(m.battery()) + " is not within 0 to 1");
    state.battery = m.battery();
  }
  if (m.health().size() > limits::health_bytes)
    return failure(ErrorCode::bad_input, "health: " + std::to_string(m.health().size()) + " bytes, at most " +
                                             std::to_string(limits::health_bytes));
  state.health = printable(m.health());
  return state;
}

}  // namespace headframe
