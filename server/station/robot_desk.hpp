#pragma once

#include "server/security/robot_gate.hpp"
#include "server/station/robot_admin.hpp"

namespace headframe {

/// Offers the gate to the operator API. Thread safe. `gate` must outlive this object.
class RobotDesk : public RobotAdmin {
 public:
  /// fingerprint: 32 bytes.
  RobotDesk(RobotGate& gate, std::string fingerprint, std::string address)
      : gate_(gate), fingerprint_(std::move(fingerprint)), address_(std::move(address)) {}

  std::vector<RobotRow> robots() const override;
  std::string fingerprint() const override;
  std::string address() const override { return address_; }
  void add(const std::string& robot, const std::function<void(const Result<std::string>&)>& done) override;
  void revoke(const std::string& robot, const std::function<void(const Result<void>&)>& done) override;
  void set_rate(const std::string& robot, std::uint64_t kib_s,
                const std::function<void(const Result<void>&)>& done) override;

 private:
  RobotGate& gate_;
  const std::string fingerprint_;
  const std::string address_;  // for robots: from the configuration, or where the server listens
};

}  // namespace headframe
