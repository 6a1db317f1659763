#pragma once
// Converts messages to values and back. Every from_proto checks all fields: what it returns is safe to use, and its
// error (bad_input) names the field. All functions are pure and thread safe.

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "common/session/cloud_policy.hpp"
#include "common/session/keyframe.hpp"
#include "common/session/live_state.hpp"
#include "headframe/v1/robot.pb.h"

namespace headframe {

/// A descriptor family as a session's hello states it.
struct FamilySpec {
  FamilyId id;
  std::size_t q_size = 0;
  std::size_t w_size = 0;
};

/// A robot's identity. Does not contain the protocol version: check that first, so that other versions get the right
/// error.
struct Hello {
  SessionKey session;
  Sensor sensor;
  FamilySpec family;
  CloudPolicy clouds = CloudPolicy::on_request;
  std::string software;
  std::uint64_t spool_id = 0;
  std::string token{};                      // 32 bytes; empty: it has no credential
  std::string enrolment_code{};             // 16 bytes, or empty
  std::vector<std::uint64_t> spool_runs{};  // the present run of the spool last; empty: not stated
  bool spare = false;                       // beside the connection that carries the session
  std::vector<std::string> capabilities{};  // common/wire/capabilities.hpp; empty: its version predates them
};

/// Robot, session, family and model names: 1 to limits::name_bytes bytes, printable, without '/', neither "." nor "..".
/// They become file names and parts of URLs.
Result<void> check_name(std::string_view what, std::string_view name);

v1::Pose to_proto(const Pose& T);
Result<Pose> from_proto(const v1::Pose& message);

v1::SessionKey to_proto(const SessionKey& key);
Result<SessionKey> from_proto(const v1::SessionKey& message);

v1::Sensor to_proto(const Sensor& sensor);
Result<Sensor> from_proto(const v1::Sensor& message);

v1::Family to_proto(const FamilySpec& family);
Result<FamilySpec> from_proto(const v1::Family& message);

v1::Hello to_proto(const Hello& hello);  // states protocol_version
Result<Hello> from_proto(const v1::Hello& message);

v1::LiveState to_proto(const LiveState& state);  // its health is cut to the limit
Result<LiveState> from_proto(const v1::LiveState& message);

/// q and w are sent as binary16: a value beyond +-65504 is an error in both directions (invalid_argument, bad_input).
/// Zeros at the end of q are not sent; the reader, who knows the family, restores them with complete().
Result<v1::Keyframe> to_proto(const Keyframe& keyframe);
Result<Keyframe> from_proto(const v1::Keyframe& message);

/// Restores the zeros at the end of q that were not sent. bad_input: q is longer than the hello announced, or w has
/// another size.
Result<void> complete(Keyframe& keyframe, const FamilySpec& family);

}  // namespace headframe
