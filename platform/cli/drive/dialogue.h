// A CiA 402 drive commanded by SDO, for commissioning, not for running it.
#pragma once

#include "hal/drive/cia402_text.h"
#include "platform/cli/bus/node_dialogue.h"
#include "platform/rt/last_resort.h"

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

}  // namespace godobject
