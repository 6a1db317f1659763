#pragma once
// Local origins: robots may count their metres from anywhere (a mine grid, UTM), the numeric rooms only near zero.

#include <map>
#include <span>
#include <string>

#include "common/session/keyframe.hpp"
#include "server/atlas/atlas.hpp"
#include "server/atlas/decisions.hpp"
#include "server/session/session_cut.hpp"

namespace headframe {

/// Translates between the frames of the robots and frames near each session's own first keyframe, which single
/// precision can hold. An origin is that keyframe's position in whole kilometres, so that sessions that start near zero
/// keep their numbers bit for bit. Pure values, doubles throughout. Not thread safe.
class SessionFrames {
 public:
  /// Farther from its session's first keyframe nothing is believed: float holds 2 mm there, and no tunnel is so long.
  static constexpr double farthest_m = 20e3;

  /// The keyframe in its session's local frame. The session's first one sets the origin. A keyframe keeps its number
  /// and nothing else (it stays where the one before it was, without walls, descriptor or cloud) when it lies beyond
  /// farthest_m, or behind a jump of the odometry: what two robots see of each other across a jump would be joined by
  /// nothing but the jump. Up to three keyframes off the path are forgiven, then all that follow are left out.
  /// `earlier`: the session's keyframes so far, as they were taken in.
  Keyframe taken_in(SessionId session, Keyframe keyframe, std::span<const Keyframe> earlier);

  /// Its keyframes will come anew, from the first on, which sets the same origin again.
  void come_anew(SessionId session);

  /// Of the session's last keyframes.
  SessionCut cut(SessionId session) const;

  /// Of a session without keyframes: zero.
  Eigen::Vector3d origin_m(SessionId session) const;

  /// T_a_b between the local frames, from one between the robots' frames, and back.
  Pose local(SessionId a, SessionId b, const Pose& T_a_b) const;
  Pose given_out(SessionId a, SessionId b, const Pose& T_a_b) const;

  Alignment local(Alignment alignment) const;
  Alignment given_out(Alignment alignment) const;
  Atlas given_out(Atlas atlas) const;

 private:
  struct Frame {
    Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d first_m = Eigen::Vector3d::Zero();  // local, as the last one
    Keyframe last = {};                                 // that was taken; its descriptor and walls are left out
    int left_out = 0;                                   // since then
    std::string why = {};
  };
  std::map<SessionId, Frame> frames_;
};

}  // namespace headframe
