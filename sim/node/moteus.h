// Simulated moteus controller: registers over CAN FD, torque by feed-forward.
#pragma once

#include "hal/drive/moteus.h"
#include "sim/node/node.h"

namespace godobject {

/// In mode 10 with both gains scaled to zero it applies the feed-forward torque; with gains it applies none,
/// because position control is not simulated. Without a command within the watchdog time it leaves mode 10
/// for mode 11. Modes 11 and 1 are left by a stop only.
class SimMoteus final : public SimNode, public SimMotor {
 public:
  /// bus: opened by the caller, outlives this. fault_when_commanded: register 00Fh of a fault raised on
  /// entering mode 10; 0: none.
  SimMoteus(CanBus& bus, const DriveParams& params, int fault_when_commanded = 0) noexcept;

  void poll(Nanoseconds now) noexcept override;
  Nanoseconds next_timer() const noexcept override;
  std::uint8_t node_id() const noexcept override { return params_.node_id; }
  void power_cycle(Nanoseconds now) noexcept override;
  void trip(std::uint16_t error_code) noexcept override;
  void set_clock_error(double ppm, Nanoseconds) noexcept override { clock_rate_ = 1 + 1e-6 * ppm; }

  void set_joint(double q, double q_dot) noexcept override {
    q_ = q;
    q_dot_ = q_dot;
  }
  double applied_torque_Nm() const noexcept override;

  int mode() const noexcept { return static_cast<int>(values_[moteus::mode]); }
  /// Returns how often it entered mode 10 by a command.
  int times_enabled() const noexcept { return times_enabled_; }

 private:
  static constexpr std::size_t num_registers = 0x40;

  void on_frame(const CanFrame& frame, Nanoseconds now) noexcept;
  void write(std::uint32_t reg, double value, Nanoseconds now) noexcept;
  void measure() noexcept;
  Nanoseconds watchdog_ns() const noexcept;

  CanBus& bus_;
  DriveParams params_;
  int fault_when_commanded_;
  int times_enabled_ = 0;
  double q_ = 0, q_dot_ = 0;
  std::array<double, num_registers> values_{};
  double clock_rate_ = 1;
  Nanoseconds t_command_ns_ = 0;
};

}  // namespace godobject
