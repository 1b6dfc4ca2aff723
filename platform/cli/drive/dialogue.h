// A CiA 402 drive commanded by SDO: for bringing it up, not for running it.
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

  /// Opens the bus and makes sure that a CiA 402 drive answers. Reports to stderr.
  ExitCode open();
  NodeDialogue& node() { return node_; }

  /// Where the drive does not answer: none, false, and node().failure() says why.
  std::optional<std::uint16_t> statusword();
  std::optional<cia402::DriveState> state();
  bool command(std::uint16_t controlword);

 private:
  NodeDialogue node_;
};

/// A drive that is given power, and in every case loses it again: at the latest in the destructor.
///
/// It is held in NMT pre-operational, so that no PDO moves it. Where it can (1016h, 6007h) it is told to switch
/// itself off when it has not heard this program for half a second: killed, or the cable off. A program that dies of a
/// defect still sends it disable voltage.
class PoweredDrive {
 public:
  explicit PoweredDrive(DriveDialogue& drive) : drive_(drive) {}
  ~PoweredDrive() { static_cast<void>(off()); }
  PoweredDrive(const PoweredDrive&) = delete;
  PoweredDrive& operator=(const PoweredDrive&) = delete;

  /// Refuses while a host runs the bus, in fault, when it is powered already, and for a mode that the drive does
  /// not have. Afterwards the mode is in effect, the drive still without power. Reports to stderr.
  ExitCode prepare(cia402::OperationMode mode);
  /// To Operation Enabled. The targets must be at rest. Reports to stderr.
  ExitCode enable();
  /// Disable voltage, and the settings as they were. Other than ok: it could not be confirmed, which is
  /// reported to stderr. Nothing more to do the second time.
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
