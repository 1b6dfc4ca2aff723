// Parameters of a rig: a tree of joints with handles, encoders and drives on the joints, and their buses. Set
// at set-up (from a scene file), constant while running.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/can/params.h"
#include "hal/drive/params.h"
#include "hal/joint/transmission.h"
#include "hal/rig/compensation.h"

namespace godobject {

/// Function of a button while pressed.
enum class ButtonUse : std::uint8_t {
  hold,    // grips the nearest body, or releases it: acts when pressed
  clutch,  // enables a relative device: its increments are used while the button is pressed
  stop,    // emergency stop: each drive removes its torque by its own fastest means
  home,    // confirms that the device rests in its home pose: acts when pressed while homing
};

/// Names of ButtonUse in scene files, in the order of the enumeration.
inline constexpr std::array button_use_names{"hold", "clutch", "stop", "home"};

/// A digital input of a CiA 401 node: one bit of its TPDO1 {6000h:01}.
struct ButtonParams {
  ButtonUse use = ButtonUse::hold;
  std::size_t bus = 0;
  std::uint8_t node_id = 1;
  std::uint8_t bit = 0;     // 0..7
  bool active_low = false;  // pressed is 0
};

struct RigParams {
  std::vector<BusParams> buses;
  KinematicTreeParams tree;
  std::vector<TransmissionParams> transmissions{};  // none: each actuator moves its own joint
  std::vector<EncoderParams> encoders;
  std::vector<DriveParams> drives;
  std::vector<ButtonParams> buttons{};
  CompensationParams compensation{};
  double stale_after_s = 3e-3;  // age above which a sample is not valid: the pose is held
  // duration without a valid sample that is a fault, at least stale_after_s
  double lost_after_s = 0.1;
  double boot_timeout_s = 5;  // from start until every drive is enabled, without the wait for the home pose
  double heartbeat_timeout_s = 0.5;  // timeout of every node, from its first heartbeat on
  double heartbeat_period_s = 0.1;   // period of the host's own heartbeat
  std::uint8_t host_node_id = 127;
};

/// Returns the protocol of a bus: that of its drives, CANopen without drives. validate() requires one
/// protocol per bus.
inline DriveProtocol protocol_of_bus(const RigParams& rig, std::size_t bus) noexcept {
  const auto drive = std::ranges::find(rig.drives, bus, &DriveParams::bus);
  return drive == rig.drives.end() ? DriveProtocol::cia402 : drive->protocol;
}

/// Returns the number of the drive that moves a joint; none without one.
inline std::optional<std::size_t> drive_of(const RigParams& rig, const std::string& joint) noexcept {
  const auto found = std::ranges::find(rig.drives, joint, &DriveParams::joint);
  if (found == rig.drives.end()) return std::nullopt;
  return static_cast<std::size_t>(found - rig.drives.begin());
}

/// Returns the calibration of the sensor that measures a joint, its encoder or else its drive; null without
/// either.
inline const Calibration* sensor_of(const RigParams& rig, const std::string& joint) noexcept {
  const auto encoder = std::ranges::find(rig.encoders, joint, &EncoderParams::joint);
  if (encoder != rig.encoders.end()) return &encoder->calibration;
  const std::optional<std::size_t> drive = drive_of(rig, joint);
  return drive ? &rig.drives[*drive].calibration : nullptr;
}

/// True if the zero of the joint's sensor is unknown at power-on.
inline bool is_incremental(const RigParams& rig, const std::string& joint) noexcept {
  const Calibration* const sensor = sensor_of(rig, joint);
  return sensor != nullptr && sensor->incremental;
}

/// True if the joint is one of a transmission: its sensors and drive are on an actuator.
inline bool is_coupled(const RigParams& rig, const std::string& joint) {
  const auto moves = [&](const TransmissionParams& t) { return std::ranges::count(t.joints, joint) > 0; };
  return std::ranges::any_of(rig.transmissions, moves);
}

/// True if the sensors and the drive of a joint turn: on a hinge, and on any actuator of a transmission.
inline bool is_rotary(const RigParams& rig, const std::string& joint) {
  if (is_coupled(rig, joint)) return true;
  const auto found = std::ranges::find(rig.tree.joints, joint, &DeviceJoint::name);
  return found == rig.tree.joints.end() || found->kind == DeviceJointKind::hinge;
}

}  // namespace godobject
