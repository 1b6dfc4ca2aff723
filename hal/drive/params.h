// Parameters of a drive on a joint.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "hal/joint/params.h"

namespace godobject {

/// Protocol of a drive.
enum class DriveProtocol : std::uint8_t {
  cia402,  // CANopen, cyclic synchronous torque
  odrive,  // CAN Simple
  moteus,  // CAN FD
};

/// Names of DriveProtocol in scene files, in the order of the enumeration.
inline constexpr std::array drive_protocol_names{"cia402", "odrive", "moteus"};

/// Mechanism that stops a drive after the host has died.
enum class DriveWatchdog : std::uint8_t {
  host,   // set up by this program: by the node's profile, or with each command (moteus)
  drive,  // part of the drive's own configuration, not visible to this program
  none,   // none: the motor keeps its last commanded torque
};

/// Names of DriveWatchdog in scene files, in the order of the enumeration.
inline constexpr std::array drive_watchdog_names{"host", "drive", "none"};

/// Torque command and status of a CiA 402 drive; from its profile (apply_profiles).
struct Cia402Params {
  std::int8_t torque_mode = 10;         // 6061h while 6071h is followed: 10 CST, 4 profile torque
  std::uint16_t follows_mask = 0x1000;  // statusword bit set while it follows 6071h; 0: none
  std::uint16_t limit_mask = 0x0800;    // statusword bit set while it limits the torque; 0: none
};

/// A motor drive commanded in torque. Its position also measures the joint.
struct DriveParams {
  std::string joint;
  DriveProtocol protocol = DriveProtocol::cia402;
  std::size_t bus = 0;
  std::uint8_t node_id = 1;
  DriveWatchdog watchdog = DriveWatchdog::host;
  std::uint16_t watchdog_ms = 20;          // timeout set in the drive, with DriveWatchdog::drive
  double torque_rated_Nm = 0.1;            // 6076h; targets are sent in per mille of it
  double torque_max_Nm = 0.05;             // saturation of the command, at the motor shaft
  double torque_rate_Nm_per_s = 5;         // slew limit of the command, at the motor shaft
  double joint_per_motor_rad = 1;          // transmission: rad or m of the joint per rad of the motor
  int sign = 1;                            // sign of a positive motor torque on the joint
  std::uint8_t status_every_nth_sync = 1;  // transmission type of its TPDO1, 1..240
  Calibration calibration{};               // calibration of its position 6064h, to the joint coordinate
  // speed of the joint: a position that implies more is not plausible
  double max_speed = 50;
  // slip of the joint against its encoder; 0: not compared; none: slip.h
  std::optional<double> max_slip{};
  std::string profile{};      // as EncoderParams::profile
  unsigned profile_line = 0;  // as EncoderParams::profile_line
  Cia402Params cia402{};
};

}  // namespace godobject
