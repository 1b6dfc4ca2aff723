// Commissioning of one CiA 402 drive by SDO, not for running it: dialogue, power, homing (mode 6), and a
// short, slow move. The move checks motor, sensor and signs.
#pragma once

#include <atomic>
#include <optional>

#include "hal/drive/cia402_homing.h"
#include "hal/drive/cia402_text.h"
#include "platform/cli/bus/dialogue.h"
#include "platform/rt/signals.h"

namespace godobject {

namespace drive_object {
using canopen::ObjectType;
inline constexpr TypedObject error_code{{0x603F, 0}, ObjectType::u16},
    controlword{{0x6040, 0}, ObjectType::u16}, statusword{{0x6041, 0}, ObjectType::u16},
    abort_connection{{0x6007, 0}, ObjectType::i16}, quick_stop_option{{0x605A, 0}, ObjectType::i16},
    mode{{0x6060, 0}, ObjectType::i8}, mode_display{{0x6061, 0}, ObjectType::i8},
    position{{0x6064, 0}, ObjectType::i32}, velocity{{0x606C, 0}, ObjectType::i32},
    target_torque{{0x6071, 0}, ObjectType::i16}, torque_rated{{0x6076, 0}, ObjectType::u32},
    torque{{0x6077, 0}, ObjectType::i16}, target_position{{0x607A, 0}, ObjectType::i32},
    home_offset{{0x607C, 0}, ObjectType::i32}, homing_method{{0x6098, 0}, ObjectType::i8},
    homing_switch_speed{{0x6099, 1}, ObjectType::u32}, homing_zero_speed{{0x6099, 2}, ObjectType::u32},
    homing_acceleration{{0x609A, 0}, ObjectType::u32}, target_velocity{{0x60FF, 0}, ObjectType::i32},
    supported_modes{{0x6502, 0}, ObjectType::u32}, device_type{{0x1000, 0}, ObjectType::u32},
    error_register{{0x1001, 0}, ObjectType::u8}, heartbeat_consumer{{0x1016, 1}, ObjectType::u32};
}  // namespace drive_object

class DriveDialogue {
 public:
  explicit DriveDialogue(const NodeOptions& options) : node_(options) {}

  /// Opens the bus and checks that a CiA 402 drive answers. Prints errors to stderr.
  ExitCode open();
  NodeDialogue& node() { return node_; }

  /// Return none or false if the drive does not answer; node().failure() has the reason.
  std::optional<std::uint16_t> statusword();
  std::optional<cia402::DriveState> state();
  bool command(std::uint16_t controlword);

 private:
  NodeDialogue node_;
};

/// A powered drive, whose power is removed by the destructor at the latest.
///
/// The drive is kept in NMT pre-operational, so that no PDO moves it. If it supports 1016h and 6007h, it is
/// set to switch itself off half a second after the last heartbeat of this program, killed or unplugged. A
/// program that dies of a defect sends disable voltage first.
class PoweredDrive {
 public:
  explicit PoweredDrive(DriveDialogue& drive) : drive_(drive) {}
  ~PoweredDrive() { static_cast<void>(off()); }
  PoweredDrive(const PoweredDrive&) = delete;
  PoweredDrive& operator=(const PoweredDrive&) = delete;

  /// Selects the mode, with the drive still off. Refuses if a host runs the bus, if the drive is in fault or
  /// powered already, or if it does not have the mode. Prints errors to stderr.
  ExitCode prepare(cia402::OperationMode mode);
  /// Brings the drive to Operation Enabled. The targets must be at rest. Prints errors to stderr.
  ExitCode enable();
  /// Disables the voltage and restores the settings. If the off state is not confirmed, prints this to stderr
  /// and returns an error. A second call does nothing.
  ExitCode off();

 private:
  ExitCode check(cia402::OperationMode mode);
  ExitCode set_mode(cia402::OperationMode mode);
  void watch_this_program();
  bool confirm_off();
  void restore();

  DriveDialogue& drive_;
  bool prepared_ = false;
  std::optional<LastResort> last_resort_;
  std::optional<std::int64_t> former_mode_, former_consumer_, former_abort_connection_;
};

struct HomeOptions {
  int method = cia402::homing_at_current_position;  // 6098h
  std::optional<std::uint32_t> switch_speed;        // counts/s, 6099h:01; none: unchanged
  std::optional<std::uint32_t> zero_speed;          // counts/s, 6099h:02
  std::optional<std::uint32_t> acceleration;        // counts/s^2, 609Ah
  std::optional<std::int32_t> offset;               // counts, 607Ch: the position at home
  double within = 30;                               // s
};

/// True if the method takes the present position as home, so that nothing moves.
constexpr bool stands_still(int method) noexcept {
  constexpr int older_current_position = 35;
  return method == cia402::homing_at_current_position || method == older_current_position;
}

/// Powers the drive, homes it and turns it off; prints the position. Ends early if `stop` is set or an error
/// occurs, which it prints to stderr.
ExitCode home_drive(DriveDialogue& drive, const HomeOptions& options, const std::atomic<bool>& stop);

/// Trapezoidal profile with ramps of a quarter of the duration each: rate() from 0 to 1 to 0, and way(), its
/// integral, from 0 to 1.
class MoveRamp {
 public:
  explicit constexpr MoveRamp(double duration) noexcept : duration_(duration), ramp_(duration / 4) {}

  constexpr double rate(double t) const noexcept {
    const double from_end = duration_ - t;
    const double nearest = t < from_end ? t : from_end;
    return nearest <= 0 ? 0 : nearest >= ramp_ ? 1 : nearest / ramp_;
  }
  /// Returns the integral of rate() up to t, divided by the integral over the whole duration.
  constexpr double way(double t) const noexcept {
    if (t <= 0) return 0;
    if (t >= duration_) return 1;
    const double from_end = duration_ - t;
    if (t < ramp_) return t * t / (2 * ramp_) / area();
    if (from_end < ramp_) return 1 - from_end * from_end / (2 * ramp_) / area();
    return (t - ramp_ / 2) / area();
  }
  /// Returns the largest rate of change of way(), 1/s.
  constexpr double peak_rate() const noexcept { return 1 / area(); }

 private:
  constexpr double area() const noexcept { return duration_ - ramp_; }
  double duration_, ramp_;
};

struct MoveOptions {
  cia402::CommandKind kind = cia402::CommandKind::velocity;
  double value = 0;     // counts/s, relative counts, or per mille of 6076h
  double duration = 1;  // s
};

/// Powers the drive, moves it and turns it off; prints the drive's values five times a second. Ends early if
/// `stop` is set or an error occurs, which it prints to stderr.
ExitCode move_drive(DriveDialogue& drive, const MoveOptions& options, const std::atomic<bool>& stop);

}  // namespace godobject
