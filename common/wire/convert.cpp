#include "common/wire/convert.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "common/printable.hpp"
#include "common/security/secret.hpp"
#include "common/wire/capabilities.hpp"
#include "common/wire/frame_codec.hpp"
#include "common/wire/limits.hpp"

namespace headframe {
namespace {

tl::unexpected<Error> bad(const std::string& what) { return failure(ErrorCode::bad_input, what); }

Result<std::string> to_half(const std::vector<float>& values, const char* what) {
  if (values.size() > limits::descriptor_floats)
    return failure(ErrorCode::invalid_argument, std::string(what) + ": " + std::to_string(values.size()) +
                                                    " numbers, at most " + std::to_string(limits::descriptor_floats));
  std::string bytes;
  bytes.reserve(values.size() * 2);
  for (const float v : values) {
    const Eigen::half h(v);
    if (!(Eigen::numext::isfinite)(h))
      return failure(ErrorCode::invalid_argument, std::string(what) + ": a value does not fit into binary16");
    bytes.push_back(static_cast<char>(h.x & 0xff));
    bytes.push_back(static_cast<char>(h.x >> 8));
  }
  return bytes;
}

/// Drops zeros at the end, except the first number, because a q is never empty.
void leave_out_last_zeros(std::string& half) {
  while (half.size() > 2 && half[half.size() - 1] == 0 && half[half.size() - 2] == 0) half.resize(half.size() - 2);
}

Result<std::vector<float>> from_half(const std::string& bytes, const char* what) {
  if (bytes.size() % 2 != 0 || bytes.size() / 2 > limits::descriptor_floats)
    return bad(std::string(what) + ": " + std::to_string(bytes.size()) + " bytes are not up to " +
               std::to_string(limits::descriptor_floats) + " binary16 numbers");
  std::vector<float> values(bytes.size() / 2);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto low = static_cast<unsigned char>(bytes[2 * i]), high = static_cast<unsigned char>(bytes[2 * i + 1]);
    values[i] = Eigen::half_impl::half_to_float(
        Eigen::half_impl::raw_uint16_to_half(static_cast<std::uint16_t>(high << 8 | low)));
    if (!std::isfinite(values[i])) return bad(std::string(what) + ": value " + std::to_string(i) + " is not finite");
  }
  return values;
}

}  // namespace

Result<void> check_name(std::string_view what, std::string_view name) {
  const auto wrong = [&](const std::string& why) { return bad(std::string(what) + " name " + why); };
  if (name.empty()) return wrong("is empty");
  if (name.size() > limits::name_bytes)
    return wrong("has " + std::to_string(name.size()) + " bytes, at most " + std::to_string(limits::name_bytes));
  if (name == "." || name == "..") return wrong("is a dot name");
  if (name.find('/') != std::string_view::npos || printable(name) != name)
    return wrong("has a '/' or a character that can not be printed");
  return {};
}

v1::Pose to_proto(const Pose& T) {
  const Eigen::Quaterniond q(T.linear());
  v1::Pose m;
  m.set_x(T.translation().x());
  m.set_y(T.translation().y());
  m.set_z(T.translation().z());
  m.set_qx(q.x());
  m.set_qy(q.y());
  m.set_qz(q.z());
  m.set_qw(q.w());
  return m;
}

Result<Pose> from_proto(const v1::Pose& m) {
  const Eigen::Vector3d t(m.x(), m.y(), m.z());
  if (!(t.cwiseAbs().maxCoeff() <= limits::position_m) || !t.allFinite())
    return bad("pose: position is not finite or beyond 1e8 m");
  const Eigen::Quaterniond q(m.qw(), m.qx(), m.qy(), m.qz());
  const double length = q.norm();
  if (!(length > 1e-6 && length < 1e6)) return bad("pose: quaternion of length " + std::to_string(length));
  Pose T = Pose::Identity();
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() = t;
  return T;
}

v1::SessionKey to_proto(const SessionKey& key) {
  v1::SessionKey m;
  m.set_robot(key.robot);
  m.set_session(key.session);
  return m;
}

Result<SessionKey> from_proto(const v1::SessionKey& m) {
  if (auto ok = check_name("robot", m.robot()); !ok) return tl::unexpected(ok.error());
  if (auto ok = check_name("session", m.session()); !ok) return tl::unexpected(ok.error());
  return SessionKey{m.robot(), m.session()};
}

v1::Sensor to_proto(const Sensor& s) {
  v1::Sensor m;
  m.set_model(s.model);
  m.set_beams(static_cast<std::uint32_t>(s.beams));
  m.set_fov_up_deg(s.fov_up_deg);
  m.set_fov_down_deg(s.fov_down_deg);
  m.set_max_range_m(s.max_range_m);
  return m;
}

Result<Sensor> from_proto(const v1::Sensor& m) {
  if (auto ok = check_name("sensor model", m.model()); !ok) return tl::unexpected(ok.error());
  if (m.beams() > 4096) return bad("sensor: " + std::to_string(m.beams()) + " beams");
  const auto is_fov = [](float deg) { return deg >= 0 && deg <= 90; };
  if (!is_fov(m.fov_up_deg()) || !is_fov(m.fov_down_deg()))
    return bad("sensor: both fields of view are positive and at most 90 deg from the horizon");
  if (!(m.max_range_m() >= 0 && m.max_range_m() <= 1e5F)) return bad("sensor: max_range_m is not within 0 to 1e5");
  return Sensor{m.model(), static_cast<int>(m.beams()), m.fov_up_deg(), m.fov_down_deg(), m.max_range_m()};
}

v1::Family to_proto(const FamilySpec& f) {
  v1::Family m;
  m.set_name(f.id.name);
  m.set_version(static_cast<std::uint32_t>(f.id.version));
  m.set_q_size(static_cast<std::uint32_t>(f.q_size));
  m.set_w_size(static_cast<std::uint32_t>(f.w_size));
  return m;
}

Result<FamilySpec> from_proto(const v1::Family& m) {
  if (auto ok = check_name("descriptor family", m.name()); !ok) return tl::unexpected(ok.error());
  if (m.version() > 1'000'000) return bad("descriptor family: version " + std::to_string(m.version()));
  if (m.q_size() < 1 || m.q_size() > limits::descriptor_floats || m.w_size() > limits::descriptor_floats)
    return bad("descriptor family: sizes " + std::to_string(m.q_size()) + " and " + std::to_string(m.w_size()) +
               ", q has 1 to " + std::to_string(limits::descriptor_floats) + " numbers and w at most as many");
  return FamilySpec{{m.name(), static_cast<int>(m.version())}, m.q_size(), m.w_size()};
}

v1::Hello to_proto(const Hello& h) {
  v1::Hello m;
  m.set_protocol_version(protocol_version);
  *m.mutable_session() = to_proto(h.session);
  *m.mutable_sensor() = to_proto(h.sensor);
  *m.mutable_family() = to_proto(h.family);
  m.set_clouds(static_cast<v1::CloudPolicy>(h.clouds));
  m.set_software(h.software);
  m.set_spool_id(h.spool_id);
  m.set_token(h.token);
  m.set_enrolment_code(h.enrolment_code);
  *m.mutable_spool_runs() = {h.spool_runs.begin(), h.spool_runs.end()};
  m.set_spare(h.spare);
  *m.mutable_capabilities() = {h.capabilities.begin(), h.capabilities.end()};
  return m;
}

Result<Hello> from_proto(const v1::Hello& m) {
  Hello h;
  if (auto v = from_proto(m.session()))
    h.session = *v;
  else
    return tl::unexpected(v.error());
  if (auto v = from_proto(m.sensor()))
    h.sensor = *v;
  else
    return tl::unexpected(v.error());
  if (auto v = from_proto(m.family()))
    h.family = *v;
  else
    return tl::unexpected(v.error());
  if (!v1::CloudPolicy_IsValid(m.clouds())) return bad("hello: cloud policy " + std::to_string(m.clouds()));
  h.clouds = static_cast<CloudPolicy>(m.clouds());
  if (m.software().size() > limits::name_bytes) return bad("hello: software has too long a name");
  h.software = printable(m.software());
  if (m.spool_id() == 0) return bad("hello: spool_id is missing");
  h.spool_id = m.spool_id();
  const auto is_secret = [](const std::string& secret, std::size_t size) {
    return secret.empty() || secret.size() == size;
  };
  if (!is_secret(m.token(), token_bytes)) return bad("hello: a token has 32 bytes");
  if (!is_secret(m.enrolment_code(), code_bytes)) return bad("hello: an enrolment code has 16 bytes");
  h.token = m.token();
  h.enrolment_code = m.enrolment_code();
  if (static_cast<std::size_t>(m.spool_runs_size()) > limits::spool_runs) return bad("hello: too many spool_runs");
  h.spool_runs = {m.spool_runs().begin(), m.spool_runs().end()};
  if (std::find(h.spool_runs.begin(), h.spool_runs.end(), 0U) != h.spool_runs.end())
    return bad("hello: a spool run is 0");
  h.spare = m.spare();
  h.capabilities = usable_capabilities({m.capabilities().begin(), m.capabilities().end()});
  return h;
}

Result<v1::Keyframe> to_proto(const Keyframe& k) {
  auto q = to_half(k.descriptor.q, "q"), w = to_half(k.descriptor.w, "w");
  if (!q) return tl::unexpected(q.error());
  if (!w) return tl::unexpected(w.error());
  leave_out_last_zeros(*q);
  v1::Keyframe m;
  m.set_sequence(k.sequence);
  m.set_stamp_s(k.stamp_s);
  *m.mutable_t_local_sensor() = to_proto(k.T_local_sensor);
  m.set_spaciousness_m(k.spaciousness_m);
  m.set_q(std::move(*q));
  m.set_w(std::move(*w));
  m.set_place_class(static_cast<v1::PlaceClass>(k.descriptor.place_class));
  m.set_walls(k.walls.code.data(), k.walls.code.size());
  m.set_point_count(k.point_count);
  return m;
}

Result<Keyframe> from_proto(const v1::Keyframe& m) {
  const auto wrong = [&](const std::string& what) {
    return bad("keyframe " + std::to_string(m.sequence()) + ": " + what);
  };
  if (m.sequence() < 1) return wrong("sequences start at 1");
  if (!std::isfinite(m.stamp_s())) return wrong("stamp_s is not finite");
  if (!(m.spaciousness_m() >= 0 && m.spaciousness_m() <= 1e5F)) return wrong("spaciousness_m is not within 0 to 1e5");
  if (m.walls().size() != WallProfile::sectors)
    return wrong("walls has " + std::to_string(m.walls().size()) + " bytes, not 180");
  if (m.point_count() > limits::cloud_points) return wrong("cloud of " + std::to_string(m.point_count()) + " points");
  const auto T = from_proto(m.t_local_sensor());
  if (!T) return wrong(T.error().message);
  auto q = from_half(m.q(), "q"), w = from_half(m.w(), "w");
  if (!q) return wrong(q.error().message);
  if (!w) return wrong(w.error().message);
  if (q->empty()) return wrong("q is empty");

  Keyframe k;
  k.sequence = m.sequence();
  k.stamp_s = m.stamp_s();
  k.T_local_sensor = *T;
  k.spaciousness_m = m.spaciousness_m();
  k.descriptor.q = std::move(*q);
  k.descriptor.w = std::move(*w);
  if (v1::PlaceClass_IsValid(m.place_class()))  // a class that a later version adds is read as unknown
    k.descriptor.place_class = static_cast<PlaceClass>(m.place_class());
  std::copy(m.walls().begin(), m.walls().end(), k.walls.code.begin());
  k.point_count = m.point_count();
  return k;
}

Result<void> complete(Keyframe& k, const FamilySpec& family) {
  if (k.descriptor.q.size() > family.q_size || k.descriptor.w.size() != family.w_size)
    return bad("keyframe " + std::to_string(k.sequence) + ": q and w of " + std::to_string(k.descriptor.q.size()) +
               " and " + std::to_string(k.descriptor.w.size()) + " numbers, the hello announced " +
               std::to_string(family.q_size) + " and " + std::to_string(family.w_size));
  k.descriptor.q.resize(family.q_size, 0);
  return {};
}

}  // namespace headframe
