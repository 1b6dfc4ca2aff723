// CiA 402 drives in cyclic synchronous torque mode: implementation of DriveLink.
#pragma once

#include "hal/drive/cia402.h"
#include "hal/drive/link.h"

namespace godobject {

/// SYNC requests the status. The RPDO1 of every cycle carries controlword and torque and takes effect at the
/// next SYNC. The rig does node supervision (NMT, heartbeat, EMCY).
///
/// Enabled means: in Operation Enabled, the statusword shows that the drive follows the command (bit 12), and
/// its last TPDO2, if any, reports the torque mode. Mode and bits: DriveParams::cia402. After it has followed
/// once, a drive may clear bit 12 while it limits the torque and stays enabled. It limits if bit 11 is set or
/// the torque is below its target.
///
/// A fault is reset by an edge of bit 7. Each level is held until the state changes, at most for
/// fault_reset_hold_ns, because drives may read the controlword rarely.
class Cia402Link final : public DriveLink {
 public:
  /// params: constant and outliving the link.
  Cia402Link(const DriveParams& params, double /*cycle_s*/) noexcept : params_(params) {}
  Cia402Link(const DriveParams&&, double) = delete;  // a temporary would not outlive it

  DriveMessage decode(const CanFrame& frame, DriveTelemetry& out) noexcept override;
  std::optional<CanFrame> request(const DriveOrder&) const noexcept override { return {}; }
  DriveFrame command(const DriveOrder& order, Nanoseconds now) const noexcept override;
  void sent(const DriveFrame& command, Nanoseconds now) noexcept override;
  std::vector<CyclicMessage> messages(double cycle_s, double event_period_s) const override;

 private:
  std::uint16_t controlword(DriveGoal goal, Nanoseconds now) const noexcept;
  MotorState motor_state() const noexcept;
  bool is_held_back(std::int16_t actual_per_mille) const noexcept;

  const DriveParams& params_;
  cia402::DriveState state_ = cia402::DriveState::unknown;
  std::uint16_t statusword_ = 0;
  bool follows_ = false;                     // follows the command, or limits after it has followed
  std::optional<std::int8_t> shown_mode_{};  // 6061h of TPDO2
  std::uint16_t controlword_ = cia402::disable_voltage;
  std::array<int, 2> targets_per_mille_{};        // last two targets sent; a status may refer to either
  std::optional<Nanoseconds> t_reset_edge_ns_{};  // last change of bit 7 of the controlword
};

namespace cia402 {

/// Packs DriveTelemetry::own_state: statusword, above it 6061h and a bit that 6061h is valid.
constexpr std::uint32_t own_state(std::uint16_t statusword, std::optional<std::int8_t> mode) noexcept {
  constexpr std::uint32_t known = 1u << 24;
  return mode ? known | std::uint32_t{static_cast<std::uint8_t>(*mode)} << 16 | statusword : statusword;
}
/// Returns "operation enabled (6041h = 0237h), bit 12 is not set: ...".
std::string state_text(const DriveParams& params, std::uint32_t own_state);
std::string error_text(std::uint32_t error_code, std::uint32_t own_state);

}  // namespace cia402
}  // namespace godobject
