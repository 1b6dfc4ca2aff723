// Parameters of the device's joints: their tree with its handles, and their encoders.
#pragma once

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
  Pose X_PJ{};                             // joint frame in the parent's link frame
  Vec3 axis_J = Vec3::UnitZ();             // unit
  double mass = 0;                         // of its link, kg, >= 0
  Vec3 p_LM = Vec3::Zero();                // centre of mass, in the link's frame
  std::optional<double> lower{}, upper{};  // ends of its range, rad or m; absent: not known
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
  // true: the count at power-on is arbitrary. Homing measures offset_counts in the device's home pose.
  bool incremental = false;
};

/// An encoder (CiA 406).
struct EncoderParams {
  std::string joint;         // name of the measured joint
  std::size_t bus = 0;       // index into the scene's buses
  std::uint8_t node_id = 1;  // 1..127
  Calibration calibration{};
  double max_speed = 50;      // rad/s or m/s: a sample that implies more is not plausible
  std::string profile{};      // profile that sets up the node; empty: no set-up
  unsigned profile_line = 0;  // line in the scene file; 0: no file
};

}  // namespace godobject
