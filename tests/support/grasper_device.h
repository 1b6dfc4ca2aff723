// A device with the joints of a laparoscopic grasper. They are a universal joint in the trocar (two hinges),
// a shaft that slides and rotates in it, and two jaws on its end. Four handles: trocar, shaft and both jaws.
// Encoders on every joint; drives on all but the shaft's rotation.
#pragma once

#include <numbers>

#include "hal/rig/params.h"

namespace godobject::test {

inline KinematicTreeParams grasper_tree() {
  const auto at = [](double x, double y, double z, double angle = 0, const Vec3& axis = Vec3::UnitX()) {
    return Pose{Vec3(x, y, z), Quat(Eigen::AngleAxisd(angle, axis))};
  };
  KinematicTreeParams tree;
  tree.X_WB = at(0.1, -0.05, 0.2, 0.4, Vec3(1, 2, 2) / 3);
  tree.joints = {
      {.name = "pitch", .axis_J = Vec3::UnitX()},
      {.name = "yaw", .axis_J = Vec3::UnitY()},
      {.name = "insertion", .kind = DeviceJointKind::slider, .axis_J = -Vec3::UnitZ()},
      {.name = "roll", .X_PJ = at(0, 0, -0.1), .axis_J = Vec3::UnitZ()},
      {.name = "jaw_left", .X_PJ = at(0.005, 0, -0.15, 0.1), .axis_J = Vec3::UnitY()},
      {.name = "jaw_right", .parent = "roll", .X_PJ = at(-0.005, 0, -0.15, -0.1), .axis_J = -Vec3::UnitY()},
  };
  tree.handles = {
      {.body = "trocar", .joint = "yaw", .X_LH = at(0, 0, 0.01)},
      {.body = "shaft", .joint = "roll", .X_LH = at(0, 0, -0.07)},
      {.body = "left", .joint = "jaw_left", .X_LH = at(0.002, 0, -0.01, 0.3)},
      {.body = "right", .joint = "jaw_right", .X_LH = at(-0.002, 0, -0.01, -0.3)},
  };
  return tree;
}

inline RigParams grasper_rig_params() {
  RigParams rig;
  rig.buses = {{.name = "can0"}, {.name = "can1"}, {.name = "can2"}};
  rig.tree = grasper_tree();
  const auto is_slider = [](const DeviceJoint& joint) { return joint.kind == DeviceJointKind::slider; };
  for (std::size_t i = 0; i < rig.tree.joints.size(); ++i) {
    const DeviceJoint& joint = rig.tree.joints[i];
    const double counts_per_turn = 65536, counts_per_m = 1e5;
    EncoderParams encoder{.joint = joint.name, .node_id = static_cast<std::uint8_t>(i + 1)};
    encoder.calibration = {
        .counts_per_unit = is_slider(joint) ? counts_per_m : counts_per_turn / (2 * std::numbers::pi),
        .sign = i % 2 == 0 ? 1 : -1,
        .offset_counts = static_cast<std::int64_t>(9000 * i),
        .modulus_counts = 65536,
        .home = 0.01 * static_cast<double>(i)};
    rig.encoders.push_back(encoder);
  }
  for (std::size_t i = 0; i < rig.tree.joints.size(); ++i) {
    const DeviceJoint& joint = rig.tree.joints[i];
    if (joint.name == "roll") continue;
    DriveParams drive{.joint = joint.name};
    drive.bus = i < 3 ? 1 : 2;
    drive.node_id = static_cast<std::uint8_t>(i + 1);
    drive.torque_rated_Nm = 0.2;
    drive.torque_max_Nm = 0.15;
    drive.torque_rate_Nm_per_s = 20;
    drive.joint_per_motor_rad = is_slider(joint) ? 0.01 : 0.1;
    drive.sign = i % 2 == 0 ? -1 : 1;
    drive.calibration = {.counts_per_unit = 1e4, .sign = drive.sign, .home = -0.02};
    rig.drives.push_back(drive);
  }
  return rig;
}

}  // namespace godobject::test
