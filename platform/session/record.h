// What one period of a run leaves for those who look on: traces, statistics, the status line.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "hal/rig/rig.h"
#include "platform/engine/engine.h"

namespace godobject {

/// Distance and angle between two poses.
struct PoseError {
  double m = 0;
  double rad = 0;
};

inline PoseError between(const Pose& a, const Pose& b) noexcept {
  return {.m = (a.p - b.p).norm(), .rad = rotation_error(a.q, b.q, Vec3::Zero()).phi_B.norm()};
}
inline PoseError worst(const PoseError& a, const PoseError& b) noexcept {
  return {.m = std::max(a.m, b.m), .rad = std::max(a.rad, b.rad)};
}

/// The devices' sample of one target, as the core got it: in the order of motion_targets().
struct TargetSample {
  Pose X_WD;    // pose of the device; of a relative one, or one that takes hold, not that of a body's target
  Wrench F_WB;  // force of the hand (admittance)
  bool engaged = true, clutch = true;
};

/// What one cycle did. Records of one session have the same number of bodies: once a record is one of them,
/// taking over another allocates nothing, so that a real-time thread can hand it to another.
struct CycleRecord {
  std::uint64_t cycle = 0;  // from 1
  double t = 0;             // of the state, s
  bool engaged = false;     // the device holds the first driven body, or one that it has taken hold of
  std::vector<BodyView> bodies;
  Fault fault = Fault::none;
  Limited limited = Limited::none;
  ContactReport contacts;
  NetReport nets;
  double net_stretch = 0;  // l / l_0 of the spring that is stretched most
  RigFault rig_faults = RigFault::none;
  bool on_hold = false;  // too many deadlines were missed: see Session::hold()
  CommandReport drives;  // bounds on the motor commands
  bool force_oscillates =
      false;  // what is shown has begun to swing between its bounds: of a rig also a fault
  // Where the device takes hold of bodies:
  std::optional<std::size_t> held;  // index of the held body
  Wrench hand_W;                    // shown to the hand, about the device's origin, world axes
  // Worst of the driven bodies. The handle is where the device really is; without a bus, where the motion is;
  // on a real bus, where nobody knows, what the core was told: sensing is then zero.
  PoseError following;  // body against handle (relative devices, and what is held: against its target)
  PoseError sensing;    // sample the core got against handle
  // The same of an engine beside it that is told the handle exactly; zero without a simulated bus.
  PoseError exact_following;  // its body against the handle
  PoseError encoders;         // body against its body
  EnergyReport energy;
  // Contacts that bear a force, with room for all that can; no room unless the session lists them.
  std::vector<ContactView> touching;
  std::size_t num_touching = 0;
  // Where the nodes of nets are, in the order of Engine::nets(); no room unless the session lists them.
  std::vector<Vec3> net_nodes;
  Nanoseconds step_ns = 0;  // the engine's step alone, by the step clock
  // On the clock of the buses, 0 without any: the begin of this period, and of the one in which t was 0.
  Nanoseconds t_bus_ns = 0, motion_start_ns = 0;
  std::vector<TargetSample> targets;
  std::vector<double>
      joint_q;  // coordinates of the scene's joints, one joint after the other; turns are counted
  std::vector<double> device_q;      // of the device's joints; NaN while they are not known
  std::vector<double> drive_torque;  // commanded, N m or N at the joint, one per RigParams::drives
};

}  // namespace godobject
