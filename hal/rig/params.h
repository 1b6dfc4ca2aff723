// What a rig is made of: a tree of joints with handles, the encoders and drives on the joints, the buses
// they hang on. Filled at set-up (from a scene file), constant while running.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/math/types.h"

namespace godobject {

enum class DeviceJointKind : std::uint8_t { hinge, slider };

/// What DeviceJoint::parent calls the base. No joint has this name.
inline constexpr const char* base_name = "base";

/// One joint of the device and the link it carries. Its coordinate q is rad (hinge) or m (slider);
/// X_PL(q) = X_PJ * (turn or shift by q about/along axis_J).
struct DeviceJoint {
  std::string name;
  std::string parent{};  // an earlier joint, on whose link it sits, or base_name; empty: the joint before
  DeviceJointKind kind = DeviceJointKind::hinge;
  Pose X_PJ{};                  // joint frame in the parent's link frame
  Vec3 axis_J = Vec3::UnitZ();  // unit
};

/// Where the user holds a body of the tool: the handle is the target of that body.
struct HandleParams {
  std::string body;   // name of a coupled body; each has at most one handle
  std::string joint;  // the handle is fixed to the link of this joint
  Pose X_LH{};        // handle in that link's frame
};

/// Tree of links from the world to the handles. A serial arm is the tree without branches.
struct KinematicTreeParams {
  Pose X_WB{};                        // base of the device in the world
  std::vector<DeviceJoint> joints;    // every parent before its children
  std::vector<HandleParams> handles;  // their order is that of samples and commands
};

/// Counts to the joint coordinate: q = home + sign * (counts - offset_counts) / counts_per_unit.
/// To home a sensor: bring its joint to a place that is known, e.g. in a jig; write down the counts and the
/// coordinate there.
struct Calibration {
  double counts_per_unit = 1;        // counts per rad or per m, > 0
  int sign = 1;                      // +1 or -1
  std::int64_t offset_counts = 0;    // count at q = home
  std::uint64_t modulus_counts = 0;  // counts wrap at this value; 0: they do not wrap (32 bits)
  double home = 0;                   // rad or m
};

/// An absolute encoder (CiA 406).
struct EncoderParams {
  std::string joint;         // name of the joint it measures
  std::size_t bus = 0;       // index into the scene's buses
  std::uint8_t node_id = 1;  // 1..127
  Calibration calibration{};
  double max_speed = 50;      // rad/s or m/s: a sample that implies more is not plausible
  std::string profile{};      // how the node is set up; empty: not at all, it is as the rig expects it
  unsigned profile_line = 0;  // of the scene file that names it; 0: no file
};

/// What a drive speaks.
enum class DriveProtocol : std::uint8_t {
  cia402,  // CANopen, cyclic synchronous torque
  odrive,  // CAN Simple
  moteus,  // CAN FD
};

/// Names of DriveProtocol in scene files, in its order.
inline constexpr std::array drive_protocol_names{"cia402", "odrive", "moteus"};

/// Who sees to it that a drive stops when the host has died.
enum class DriveWatchdog : std::uint8_t {
  host,   // this program sets it up: by the node's profile, or with each command (moteus)
  drive,  // it is part of the drive's own configuration, which this program does not see
  none,   // nobody: the motor keeps the last torque it was told
};

/// Names of DriveWatchdog in scene files, in its order.
inline constexpr std::array drive_watchdog_names{"host", "drive", "none"};

/// How a CiA 402 drive takes torque and reports it: of its profile (apply_profiles).
struct Cia402Params {
  std::int8_t torque_mode = 10;         // 6061h while 6071h is followed: 10 CST, 4 profile torque
  std::uint16_t follows_mask = 0x1000;  // statusword bit that is set while it follows 6071h; 0: it has none
  std::uint16_t limit_mask = 0x0800;  // statusword bit that is set while it limits the torque; 0: it has none
};

/// A motor drive commanded in torque. It also measures its joint.
struct DriveParams {
  std::string joint;
  DriveProtocol protocol = DriveProtocol::cia402;
  std::size_t bus = 0;
  std::uint8_t node_id = 1;
  DriveWatchdog watchdog = DriveWatchdog::host;
  std::uint16_t watchdog_ms = 20;          // what is set in the drive, with DriveWatchdog::drive
  double torque_rated_Nm = 0.1;            // 6076h; targets travel in per mille of it
  double torque_max_Nm = 0.05;             // saturation of the command, at the motor shaft
  double torque_rate_Nm_per_s = 5;         // slew limit of the command, at the motor shaft
  double joint_per_motor_rad = 1;          // transmission: rad or m of the joint per rad of the motor
  int sign = 1;                            // of a positive motor torque on the joint
  std::uint8_t status_every_nth_sync = 1;  // transmission type of its TPDO1, 1..240
  Calibration calibration{};               // of its position 6064h, to the joint coordinate
  double max_speed = 50;                   // of the joint: a position that implies more is not plausible
  std::optional<double> max_slip{};        // of the joint, against its encoder; 0: not compared; none: slip.h
  std::string profile{};                   // as EncoderParams::profile
  unsigned profile_line = 0;               // as EncoderParams::profile_line
  Cia402Params cia402{};
};

/// What a button does while it is pressed.
enum class ButtonUse : std::uint8_t {
  hold,    // takes hold of the nearest body and lets go of it again: acts when it goes down
  clutch,  // of a relative device: its increments count while the button is down
};

/// Names of ButtonUse in scene files, in its order.
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
  double cycle_s = 1e-3;             // SYNC period
  double stale_after_s = 3e-3;       // a sample older than this is not valid any more: the pose is held
  double lost_after_s = 0.1;         // (at least stale_after_s) without a valid one for so long: a fault
  double boot_timeout_s = 5;         // from start to every drive enabled
  double heartbeat_timeout_s = 0.5;  // of every node, once it has been heard
  double heartbeat_period_s = 0.1;   // of the host's own heartbeat
  std::uint8_t host_node_id = 127;
};

}  // namespace godobject
