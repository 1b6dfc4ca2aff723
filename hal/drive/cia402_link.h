// CiA 402 drives in cyclic synchronous torque mode, as the rig commands them.
#pragma once

#include "hal/drive/cia402.h"
#include "hal/drive/link.h"

namespace godobject {

/// SYNC asks for the status; the RPDO1 of every cycle carries controlword and torque and takes effect at the
/// next SYNC. Node supervision (NMT, heartbeat, EMCY) is the rig's.
///
/// Enabled is a drive in Operation Enabled whose statusword shows that it follows the command (bit 12) and
/// whose TPDO2, if it has sent one, does not name another mode than the torque mode. Mode and bits:
/// DriveParams::cia402. Once it has followed, a drive that limits the torque (bit 11, or less torque than its
/// target) may clear bit 12 meanwhile: it stays enabled.
///
/// Fault is reset by an edge of bit 7. Drives may look at the controlword seldom: each level is kept until
/// the state changes, and for fault_reset_hold_ns otherwise.
class Cia402Link final : public DriveLink {
 public:
  Cia402Link(const DriveParams& params, double /*cycle_s*/) noexcept : params_(params) {}

  DriveMessage decode(const CanFrame& frame, DriveTelemetry& out) noexcept override;
  std::optional<CanFrame> request(const DriveOrder&) const noexcept override { return {}; }
  DriveFrame command(const DriveOrder& order, Nanoseconds now) const noexcept override;
  void sent(const DriveFrame& command, Nanoseconds now) noexcept override;
  std::vector<CyclicMessage> messages(double cycle_s, double event_period_s) const override;

 private:
  std::uint16_t controlword(DriveGoal goal, Nanoseconds now) const noexcept;
  MotorState motor_state() const noexcept;
  bool is_held_back(std::int16_t actual_per_mille) const noexcept;

  DriveParams params_;
  cia402::DriveState state_ = cia402::DriveState::unknown;
  std::uint16_t statusword_ = 0;
  bool follows_ = false;                     // or limits, after it has followed
  std::optional<std::int8_t> shown_mode_{};  // 6061h of TPDO2
  std::uint16_t controlword_ = cia402::disable_voltage;
  std::array<int, 2> targets_per_mille_{};        // the last two sent: a status may be of either
  std::optional<Nanoseconds> t_reset_edge_ns_{};  // bit 7 of the controlword changed last
};

namespace cia402 {

/// DriveTelemetry::own_state: the statusword, and above it 6061h and whether it is known.
constexpr std::uint32_t own_state(std::uint16_t statusword, std::optional<std::int8_t> mode) noexcept {
  constexpr std::uint32_t known = 1u << 24;
  return mode ? known | std::uint32_t{static_cast<std::uint8_t>(*mode)} << 16 | statusword : statusword;
}
/// "operation enabled (6041h = 0237h), bit 12 is not set: ...".
std::string state_text(const DriveParams& params, std::uint32_t own_state);
std::string error_text(std::uint32_t error_code, std::uint32_t own_state);

}  // namespace cia402
}  // namespace godobject
