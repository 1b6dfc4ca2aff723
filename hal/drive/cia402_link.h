// CiA 402 drives in cyclic synchronous torque mode, as the rig commands them.
#pragma once

#include "hal/drive/cia402.h"
#include "hal/drive/link.h"

namespace godobject {

/// SYNC asks for the status; the RPDO1 of every cycle carries controlword and torque and takes effect at the
/// next SYNC. Node supervision (NMT, heartbeat, EMCY) is the rig's.
///
/// Enabled is a drive in Operation Enabled whose statusword says that it follows the command (bit 12) and
/// whose TPDO2, if it has sent one, does not name another mode than CST.
class Cia402Link final : public DriveLink {
 public:
  Cia402Link(const DriveParams& params, double /*cycle_s*/) noexcept : params_(params) {}

  DriveMessage decode(const CanFrame& frame, DriveTelemetry& out) noexcept override;
  std::optional<CanFrame> request(const DriveOrder&) const noexcept override { return {}; }
  DriveFrame command(const DriveOrder& order, Nanoseconds now) const noexcept override;
  void sent(const DriveFrame& command, Nanoseconds) noexcept override { controlword_ = command.step; }
  std::vector<CyclicMessage> messages(double cycle_s, double event_period_s) const override;

 private:
  std::uint16_t controlword(DriveGoal goal) const noexcept;
  MotorState motor_state(std::uint16_t statusword) const noexcept;

  DriveParams params_;
  cia402::DriveState state_ = cia402::DriveState::unknown;
  bool other_mode_ = false;  // as TPDO2 said
  std::uint16_t controlword_ = cia402::disable_voltage;
};

}  // namespace godobject
