#pragma once
// Local origins: robots may use large coordinates (a mine grid, UTM), but the numeric code needs small ones.

#include <map>
#include <span>
#include <string>

#include "common/session/keyframe.hpp"
#include "server/atlas/atlas.hpp"
#include "server/atlas/decisions.hpp"
#include "server/session/session_cut.hpp"

namespace headframe {

/// Converts between the robots' frames and local frames near each session's first keyframe, which single precision can
/// represent. An origin is that keyframe's position rounded to whole kilometres, so that sessions that start near zero
/// keep their coordinates bit for bit. Computes in doubles. Not thread safe.
class SessionFrames {
 public:
  /// Keyframes farther from their session's first one are ignored: float resolves 2 mm there, and no tunnel is so long.
  static constexpr double farthest_m = 20e3;

  /// Returns the keyframe in its session's local frame; the session's first keyframe sets the origin. A keyframe beyond
  /// farthest_m, or after a jump of the odometry, keeps only its number: it is put where the one before it was, without
  /// walls, descriptor or cloud, because only the jump would connect what lies on both sides of it. If the path resumes
  /// after at most three such keyframes, only those are left out, otherwise also all that follow. `earlier`: the
  /// session's keyframes so far, as returned by this function.
  Keyframe taken_in(SessionId session, Keyframe keyframe, std::span<const Keyframe> earlier);

  /// The session's keyframes will be added again, from the first on, which sets the same origin again.
  void come_anew(SessionId session);

  /// Which of the session's last keyframes are left out, and why.
  SessionCut cut(SessionId session) const;

  /// Zero for a session without keyframes.
  Eigen::Vector3d origin_m(SessionId session) const;

  /// local: T_a_b between the local frames from T_a_b between the robots' frames. given_out: the inverse.
  Pose local(SessionId a, SessionId b, const Pose& T_a_b) const;
  Pose given_out(SessionId a, SessionId b, const Pose& T_a_b) const;

  Alignment local(Alignment alignment) const;
  Alignment given_out(Alignment alignment) const;
  Atlas given_out(Atlas atlas) const;

 private:
  struct Frame {
    Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d first_m = Eigen::Vector3d::Zero();  // local, like `last`
    Keyframe last = {};  // the last keyframe that was not left out; without descriptor and walls
    int left_out = 0;    // number of keyframes left out since then
    std::string why = {};
  };
  std::map<SessionId, Frame> frames_;
};

}  // namespace headframe
