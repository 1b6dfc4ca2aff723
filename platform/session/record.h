// Record of one period of a run, for traces, statistics and the status line. Joint coordinates and the errors
// against an ideal device are computed for it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/device/cues.h"
#include "core/nonblocking.h"
#include "hal/rig/rig.h"
#include "platform/engine/engine.h"

namespace godobject {

/// Distance and angle between two poses.
struct PoseError {
  double m = 0;
  double rad = 0;
};

inline PoseError between(const Pose& a, const Pose& b) noexcept {
  const Divergence apart = divergence(b, a);
  return {.m = apart.distance, .rad = apart.angle};
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
  Nanoseconds step_ns = 0;  // duration of the engine's step alone: Stage::step
  // Start of this period and of the period with t = 0, on the clock of the buses; 0 without one.
  Nanoseconds t_bus_ns = 0, motion_start_ns = 0;
  std::vector<TargetSample> targets;
  std::vector<double>
      joint_q;  // coordinates of the scene's joints, one joint after the other; turns are counted
  std::vector<double> device_q;  // coordinates of the device's joints; NaN while unknown
  // commanded torque at the motor's shaft, N m, one per RigParams::drives
  std::vector<double> drive_torque;
  std::vector<double> drive_energy;  // generated energy of each drive's axis, J: Rig::generated_energy_J()
  // Inputs of the engine, and the hash of its state after the step: see Session::list_inputs().
  std::vector<BodySample> samples;  // one per body; empty unless the session lists them
  double passed_s = 0;              // time passed to the engine before the step: Engine::pass_time()
  std::uint64_t state_hash = 0;
};

/// Coordinates of a scene's joints, computed from the poses of its bodies.
class JointCoordinatesOf {
 public:
  explicit JointCoordinatesOf(const SceneConfig& scene);

  /// Number of coordinates of all joints: see num_coordinates().
  std::size_t size() const noexcept { return at_start_.size(); }
  /// Coordinates of all joints at the start, as coordinates_at_start().
  const std::vector<double>& at_start() const noexcept { return at_start_; }
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
  std::vector<double> at_start_;
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
  virtual void step(double t, std::span<const BodySample> samples) noexcept GODOBJECT_NONBLOCKING = 0;
  /// Writes the errors of the record that are measured against the true handle. Real-time.
  virtual void measure(const Followed& followed,
                       CycleRecord& record) const noexcept GODOBJECT_NONBLOCKING = 0;
  /// False if the motion left the workspace of the simulated device.
  virtual bool reachable() const noexcept GODOBJECT_NONBLOCKING = 0;
  /// Mean load of each bus so far, percent.
  virtual std::vector<double> bus_load_percent() const = 0;
};

// ---- limits: intended bounds of the core, the loop and the drives ----------------------------------

struct RunLimit {
  std::string_view name;  // name in the summary, the report and the view
  bool (*is_active)(const CycleRecord&) noexcept
      GODOBJECT_NONBLOCKING;  // true if the limit was active in this cycle
  std::string_view remedy;    // for a run in which the limit is often active; empty: no warning
};

template <Limited bit>
bool core_limited(const CycleRecord& record) noexcept GODOBJECT_NONBLOCKING {
  return has(record.limited, bit);
}

template <std::uint32_t CommandReport::*drives>
bool drives_limited(const CycleRecord& record) noexcept GODOBJECT_NONBLOCKING {
  return record.drives.*drives != 0;
}

/// True if the pose was held: the loop was on hold, or a sample was missing without a fault of the rig.
inline bool is_held(const CycleRecord& record) noexcept GODOBJECT_NONBLOCKING {
  return record.on_hold || (has(record.limited, Limited::held) && !any(record.rig_faults));
}

/// List of all limits: statistics, report, summary and view take names, order and remedies from here.
inline constexpr std::array run_limits{
    RunLimit{"force", core_limited<Limited::force>,
             "lower the feedback's stiffness, or raise [device.limits] force as far as the device and the "
             "hand bear it"},
    RunLimit{"torque", core_limited<Limited::torque>,
             "lower the feedback's rotational stiffness, or raise [device.limits] torque as far as the "
             "device and the hand "
             "bear it"},
    RunLimit{"force_rate", core_limited<Limited::force_rate>,
             "lower the feedback's damping and stiffness (godobject check prints the margins), or raise "
             "[device.limits] "
             "force_rate"},
    RunLimit{"torque_rate", core_limited<Limited::torque_rate>,
             "lower the feedback's rotational damping and stiffness (godobject check prints the margins), or "
             "raise "
             "[device.limits] torque_rate"},
    RunLimit{"ramp", core_limited<Limited::ramp>, ""},
    RunLimit{"held",
             [](const CycleRecord& record) noexcept GODOBJECT_NONBLOCKING {
               return has(record.limited, Limited::held) && !record.on_hold;
             },
             "find the cause of the missing samples: bus load, cables, a tracker's view of its tools"},
    RunLimit{"deadlines",
             [](const CycleRecord& record) noexcept GODOBJECT_NONBLOCKING { return record.on_hold; },
             "use a longer step, a faster machine or a real-time kernel: the loop missed its deadlines, and "
             "the pose was held "
             "meanwhile"},
    RunLimit{
        "first_order", core_limited<Limited::first_order>,
        "shorten the step, or raise net_iterations where limit net_cap is met too: TR-BDF2 falls back to "
        "implicit Euler where a body turns faster than godobject check allows, or contacts or stops change"},
    RunLimit{"contact_residual", core_limited<Limited::contact_residual>,
             "shorten the step, soften contacts, or put fewer bodies into one heap: a contact force misses "
             "its law by more than 10 % "
             "of the largest"},
    RunLimit{"newton_cap", core_limited<Limited::newton_cap>,
             "shorten the step or soften contacts: the iterations over sticking, slipping and opening "
             "contacts end before they "
             "converge"},
    RunLimit{"substeps", core_limited<Limited::substeps>,
             "shorten the step or lower the contrast of masses and inertias in the tool: stages are "
             "subdivided, to first order, "
             "because joints come apart otherwise"},
    RunLimit{
        "net_cap", core_limited<Limited::net_cap>,
        "raise net_iterations: the iteration of nets ends before its tolerance (residual_N of the report)"},
    RunLimit{
        "drive_torque", drives_limited<&CommandReport::torque_limited>,
        "lower the feedback's gains or [device.limits], or raise torque_max_Nm as far as the motor bears it"},
    RunLimit{"drive_torque_rate", drives_limited<&CommandReport::rate_limited>,
             "lower the feedback's damping and stiffness (godobject check prints the margins), or raise "
             "torque_rate_Nm_per_s"},
    RunLimit{"drive_internal_limit", drives_limited<&CommandReport::drive_limited>,
             "compare the drive's own limits with torque_max_Nm"},
    RunLimit{"drive_command_not_sent", drives_limited<&CommandReport::not_sent>,
             "lower the bus load: godobject check prints it"}};

/// Returns one bit for each entry of run_limits, set if the limit was active in this cycle.
inline std::uint32_t active_limits(const CycleRecord& record) noexcept {
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < run_limits.size(); ++i)
    bits |= (run_limits[i].is_active(record) ? 1u : 0u) << i;
  return bits;
}

}  // namespace godobject
