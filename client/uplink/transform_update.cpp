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

}  // namespace

Result<Transforms> transforms_from(const v1::TransformUpdate& message) {
  Transforms out{message.revision(), message.component(), {}, {}};
  Reader reader;
  reader.read(message.anchor(), out.anchor);
  for (const auto& from : message.sessions()) {
    auto& to = out.sessions.emplace_back();
    reader.read(from.session(), to.session);
    reader.read(from.t_component_session(), to.T_component_session);
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
