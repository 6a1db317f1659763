#pragma once
// Whether what a client sends is what the course's scans say. Pure.

#include <map>
#include <memory>
#include <string>

#include "common/descriptor/family.hpp"
#include "common/wire/convert.hpp"
#include "tests/conformance/course.hpp"
#include "tests/conformance/findings.hpp"

namespace headframe::conformance {

/// What the client was given.
struct Given {
  std::string robot;
  std::string code;  // 16 bytes of its enrolment
};

/// Remembers what a client has said on all its connections. Not thread safe.
class Judge {
 public:
  Judge(const Course& course, Given given, Findings& findings)
      : course_(course), given_(std::move(given)), findings_(findings) {}

  void hello(const v1::Hello& hello);
  /// A Welcome was sent: from now on the code need not come.
  void welcomed() { welcomed_ = true; }
  void keyframe(const v1::Keyframe& keyframe);
  void cloud(std::uint64_t sequence, const std::string& encoded);

  CloudPolicy policy() const { return policy_; }
  /// 0: it has no cloud, or never came.
  std::uint32_t points_of(std::uint64_t sequence) const;

 private:
  void identity(const v1::Hello& hello);
  void descriptor(const Keyframe& keyframe, const Points& points_level, const std::string& name);
  void walls(const Keyframe& keyframe, const Points& points_level, const std::string& name);

  const Course& course_;
  const Given given_;
  Findings& findings_;
  bool welcomed_ = false;
  CloudPolicy policy_ = CloudPolicy::on_request;
  v1::Hello first_hello_;
  std::uint64_t last_run_ = 0;
  FamilySpec family_;
  std::unique_ptr<DescriptorFamily> known_;          // null: of that name the library has none
  std::map<std::uint64_t, v1::Keyframe> keyframes_;  // by sequence, as they came first
};

}  // namespace headframe::conformance
