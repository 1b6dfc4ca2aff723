// Record of one period of a run, for traces, statistics and the status line. Joint coordinates and the errors
// against an ideal device are computed for it.
#pragma once

#include <algorithm>
#include <optional>
#include <span>
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

/// Sample of one target as passed to the core, in the order of motion_targets().
struct TargetSample {
  Pose X_WD;    // pose of the device; not of the body's target if the device is relative or grips bodies
  Wrench F_WB;  // force of the hand (admittance)
  bool engaged = true, clutch = true;
};

/// Results of one cycle. All records of a session have the same number of bodies. Assigning one to another
/// then does not allocate, so real-time threads may exchange them.
struct CycleRecord {
  std::uint64_t cycle = 0;  // from 1
  double t = 0;             // time of the state, s
  bool engaged = false;     // true while the device is engaged with the first driven body, or grips a body
  std::vector<BodyView> bodies;
  Fault fault = Fault::none;
  Limited limited = Limited::none;
  ContactReport contacts;
  NetReport nets;
  double net_stretch = 0;  // l / l_0 of the spring with the largest stretch
  RigFault rig_faults = RigFault::none;
  bool on_hold = false;  // too many deadlines were missed: see Session::hold()
  CommandReport drives;  // bounds on the motor commands
  bool force_oscillates =
      false;  // the displayed wrench started to oscillate between its bounds; with a rig also a fault
  // For devices that grip bodies:
  std::optional<std::size_t> held;  // index of the held body
  Wrench hand_W;                    // displayed to the hand, about the device's origin, world axes
  // Maxima over the driven bodies. The handle is the true pose of the device; without a bus, the pose of the
  // motion.
  // On a real bus the true pose is unknown and the core's sample replaces it; sensing is then zero.
  PoseError following;  // body against handle; against its target if the device is relative or grips bodies
  PoseError sensing;    // sample of the core against handle
  // Errors of a reference engine that receives the exact handle pose; zero without a simulated bus.
  PoseError exact_following;  // its body against the handle
  PoseError encoders;         // body against the reference engine's body
  EnergyReport energy;
  std::vector<Wrench> term_forces;  // of springs, gears and closing joints: Engine::term_forces()
  // Contacts that bear a force, with space for the maximum number. Empty unless the session lists them.
  std::vector<ContactView> touching;
  std::size_t num_touching = 0;
  // Positions of the nodes of nets, in the order of Engine::nets(). Empty unless the session lists them.
  std::vector<Vec3> net_nodes;
  Nanoseconds step_ns = 0;  // duration of the engine's step alone, by the step clock
  // Start of this period and of the period with t = 0, on the clock of the buses; 0 without one.
  Nanoseconds t_bus_ns = 0, motion_start_ns = 0;
  std::vector<TargetSample> targets;
  std::vector<double>
      joint_q;  // coordinates of the scene's joints, one joint after the other; turns are counted
  std::vector<double> device_q;  // coordinates of the device's joints; NaN while unknown
  // commanded torque, N m, or force, N, at the joint, one per RigParams::drives
  std::vector<double> drive_torque;
};

/// Coordinates of a scene's joints, computed from the poses of its bodies.
class JointCoordinatesOf {
 public:
  explicit JointCoordinatesOf(const SceneConfig& scene);

  /// Number of coordinates of all joints: see num_coordinates().
  std::size_t size() const noexcept { return size_; }
  /// Writes the coordinates of all joints. Angles are unwrapped: within half a turn of the previous ones.
  /// Real-time.
  /// bodies: all bodies of the scene. q: size() numbers; on entry the previous coordinates.
  void read(std::span<const BodyView> bodies, std::span<double> q) const noexcept;

 private:
  struct Joint {
    JointParams params;
    std::size_t child = 0;
  };
  std::vector<Joint> joints_;
  std::size_t size_ = 0;
};

/// Bodies that follow the device in a period.
struct Followed {
  std::span<const std::size_t> bodies;
  std::span<const BodySample> samples;  // one for each body of the scene, as passed to the core
  bool by_an_offset = false;  // true if handle and target differ by an offset; the error of a body is then
                              // against its target
};

/// Interface to the exact state of a simulated device: true pose of the handle, and errors against an ideal
/// device. Observes beside the session, and does not influence the bodies.
class Truth {
 public:
  virtual ~Truth() = default;

  /// Starts with the scene and the samples of the session. Allocates.
  virtual void start(const SceneConfig& scene, std::span<const BodySample> samples) = 0;
  /// Advances to t before the session's record is written. Real-time.
  /// t: time of the motion, s. samples: as in the engine's step to t.
  virtual void step(double t, std::span<const BodySample> samples) noexcept = 0;
  /// Writes the errors of the record that are measured against the true handle. Real-time.
  virtual void measure(const Followed& followed, CycleRecord& record) const noexcept = 0;
  /// False if the motion left the workspace of the simulated device.
  virtual bool reachable() const noexcept = 0;
  /// Mean load of each bus so far, percent.
  virtual std::vector<double> bus_load_percent() const = 0;
};

}  // namespace godobject
