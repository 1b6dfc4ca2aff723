// Parameters of a rig: a tree of joints with handles, encoders and drives on the joints, and their buses. Set
// at set-up (from a scene file), constant while running.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/math/types.h"

namespace godobject {

enum class DeviceJointKind : std::uint8_t { hinge, slider };

/// Name of the base in DeviceJoint::parent. No joint has this name.
inline constexpr const char* base_name = "base";

/// One joint of the device and its link. Its coordinate q is rad (hinge) or m (slider); X_PL(q) = X_PJ *
/// (rotation or translation by q about/along axis_J).
struct DeviceJoint {
  std::string name;
  std::string parent{};  // an earlier joint, the base of this one, or base_name; empty: the previous joint
  DeviceJointKind kind = DeviceJointKind::hinge;
  Pose X_PJ{};                  // joint frame in the parent's link frame
  Vec3 axis_J = Vec3::UnitZ();  // unit
};

/// Grip of the user on a body of the tool: the handle is the target of that body.
struct HandleParams {
  std::string body;   // name of a coupled body; each has at most one handle
  std::string joint;  // the handle is fixed to this joint's link
  Pose X_LH{};        // handle in that link's frame
};

/// Tree of links from the world to the handles. A serial arm is a tree without branches.
struct KinematicTreeParams {
  Pose X_WB{};                        // base of the device in the world
  std::vector<DeviceJoint> joints;    // every parent before its children
  std::vector<HandleParams> handles;  // in the order of samples and commands
};

/// Maps counts to the joint coordinate: q = home + sign * (counts - offset_counts) / counts_per_unit. To
/// calibrate a sensor, move its joint to a known place, e.g. in a jig, and record the counts and the
/// coordinate there.
struct Calibration {
  double counts_per_unit = 1;        // counts per rad or per m, > 0
  int sign = 1;                      // +1 or -1
  std::int64_t offset_counts = 0;    // count at q = home
  std::uint64_t modulus_counts = 0;  // counts wrap at this value; 0: no wrap (32 bits)
  double home = 0;                   // rad or m
};

/// An absolute encoder (CiA 406).
struct EncoderParams {
  std::string joint;         // name of the measured joint
  std::size_t bus = 0;       // index into the scene's buses
  std::uint8_t node_id = 1;  // 1..127
  Calibration calibration{};
  double max_speed = 50;      // rad/s or m/s: a sample that implies more is not plausible
  std::string profile{};      // profile that sets up the node; empty: no set-up
  unsigned profile_line = 0;  // line in the scene file; 0: no file
};

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

/// Function of a button while pressed.
enum class ButtonUse : std::uint8_t {
  hold,    // grips the nearest body, or releases it: acts when pressed
  clutch,  // enables a relative device: its increments are used while the button is pressed
};

/// Names of ButtonUse in scene files, in the order of the enumeration.
inline constexpr std::array button_use_names{"hold", "clutch"};

/// A digital input of a CiA 401 node: one bit of its TPDO1 {6000h:01}.
struct ButtonParams {
  ButtonUse use = ButtonUse::hold;
  std::size_t bus = 0;
  std::uint8_t node_id = 1;
  std::uint8_t bit = 0;     // 0..7
  bool active_low = false;  // pressed is 0
};

struct BusParams {
  std::string name;          // "can0"
  double bit_rate = 1e6;     // bit/s, arbitration phase
  double data_bit_rate = 0;  // bit/s, data phase of CAN FD; 0: a classic bus
};

struct RigParams {
  std::vector<BusParams> buses;
  KinematicTreeParams tree;
  std::vector<EncoderParams> encoders;
  std::vector<DriveParams> drives;
  std::vector<ButtonParams> buttons{};
  double stale_after_s = 3e-3;  // age above which a sample is not valid: the pose is held
  // duration without a valid sample that is a fault, at least stale_after_s
  double lost_after_s = 0.1;
  double boot_timeout_s = 5;         // from start until every drive is enabled
  double heartbeat_timeout_s = 0.5;  // timeout of every node, from its first heartbeat on
  double heartbeat_period_s = 0.1;   // period of the host's own heartbeat
  std::uint8_t host_node_id = 127;
};

}  // namespace godobject
