#include "client/uplink/transform_update.hpp"

#include <cmath>

#include "common/printable.hpp"
#include "common/wire/convert.hpp"

namespace headframe {
namespace {

constexpr std::size_t most_reason_bytes = 1024;

/// Takes over what is sound; what is not is left for the caller to report.
class Reader {
 public:
  template <class Value, class Message>
  void read(const Message& from, Value& to) {
    auto value = from_proto(from);
    if (value)
      to = std::move(*value);
    else if (!error_)
      error_ = value.error();
  }
  void read_number(double from, double& to) {
    if (!std::isfinite(from) && !error_) error_ = Error{ErrorCode::bad_input, "a number is not finite"};
    to = from;
  }
  const std::optional<Error>& error() const { return error_; }

 private:
  std::optional<Error> error_;
};

Transforms::Support support_from(const v1::TransformSupport& from, Reader& reader) {
  Transforms::Support to;
  reader.read_number(from.probability(), to.probability);
  reader.read_number(from.shared_m(), to.shared_m);
  reader.read_number(from.deviation_m(), to.deviation_m);
  reader.read_number(from.deviation_rad(), to.deviation_rad);
  to.merges = from.merges();
  to.confirmed = from.confirmed();
  if (from.has_merged_with()) reader.read(from.merged_with(), to.merged_with.emplace());
  return to;
}

}  // namespace

/// A place at distance d from the shared path also moves with the rotation error there: p = p + turn x d.
Eigen::Matrix<double, 6, 6> Transforms::Support::covariance(const Eigen::Vector3d& away_m) const {
  Eigen::Matrix3d cross;
  cross << 0, away_m.z(), -away_m.y(), -away_m.z(), 0, away_m.x(), away_m.y(), -away_m.x(), 0;
  Eigen::Matrix<double, 6, 6> out = Eigen::Matrix<double, 6, 6>::Zero();
  const double turned = deviation_rad * deviation_rad;
  out.topLeftCorner<3, 3>() =
      deviation_m * deviation_m * Eigen::Matrix3d::Identity() + turned * cross * cross.transpose();
  out.topRightCorner<3, 3>() = turned * cross;
  out.bottomLeftCorner<3, 3>() = turned * cross.transpose();
  out.bottomRightCorner<3, 3>() = turned * Eigen::Matrix3d::Identity();
  return out;
}

Result<Transforms> transforms_from(const v1::TransformUpdate& message) {
  Transforms out{message.revision(), message.component(), {}, {}};
  Reader reader;
  reader.read(message.anchor(), out.anchor);
  for (const auto& from : message.sessions()) {
    auto& to = out.sessions.emplace_back();
    reader.read(from.session(), to.session);
    reader.read(from.t_component_session(), to.T_component_session);
    if (from.has_support()) to.support = support_from(from.support(), reader);
  }
  for (const auto& from : message.provisional()) {
    auto& to = out.provisional.emplace_back();
    reader.read(from.session(), to.session);
    reader.read(from.t_component_session(), to.T_component_session);
    reader.read_number(from.probability(), to.probability);
    reader.read_number(from.awaited_m(), to.awaited_m);
  }
  for (const auto& from : message.withdrawn()) {
    auto& to = out.withdrawn.emplace_back();
    to.revision = from.revision();
    reader.read(from.a(), to.a);
    reader.read(from.b(), to.b);
    to.reason = printable(std::string_view(from.reason()).substr(0, most_reason_bytes));
  }
  if (reader.error()) return tl::unexpected(*reader.error());
  return out;
}

}  // namespace headframe
