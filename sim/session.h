// A running scene: engine, motion and, with --bus sim, the rig at both ends of its buses. cycle() is what a
// real-time loop calls once per step; it neither allocates nor waits.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "hal/rig.h"
#include "sim/engine.h"
#include "sim/grip.h"
#include "sim/motion.h"
#include "sim/sim_rig.h"

namespace godobject {

enum class BusChoice : std::uint8_t {
  sim,     // through simulated encoders, wires and drives
  direct,  // the motion is handed to the core as it is
};

inline constexpr double shut_down_limit_s = 2;

/// Distance and angle between two poses.
struct PoseError {
  double m = 0;
  double rad = 0;
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
  RigFault rig_faults = RigFault::none;
  CommandReport drives;  // bounds on the motor commands
  // Where the device takes hold of bodies:
  std::optional<std::size_t> held;  // index of the held body
  Wrench hand_W;                    // shown to the hand, about the device's origin, world axes
  // Worst of the driven bodies. The handle is where the device really is; without a bus, where the motion is.
  PoseError following;  // body against handle (relative devices, and what is held: against its target)
  PoseError sensing;    // sample the core got against handle
  // Of an engine beside it that is told the handle exactly; zero without a bus.
  PoseError exact_following;  // its body against the handle
  PoseError encoders;         // body against its body
  double energy = 0;          // J
  Nanoseconds step_ns = 0;    // the engine's step alone, by the step clock
};

class Session {
 public:
  struct Made {
    std::unique_ptr<Session> session;  // null: see errors
    std::vector<std::string> errors;
  };
  /// The motion is moved in.
  static Made make(const SceneConfig& scene, Motion motion, BusChoice bus);

  /// Brings the rig up: bus cycles with the hand at rest until every node works or `limit_s` of bus time
  /// has passed. True when the device is ready. Without a bus: true at once.
  [[nodiscard]] bool boot(double limit_s);

  /// The state before the first step. Allocates.
  CycleRecord at_start() const;

  /// One step. Real-time, for a record that comes from at_start().
  void cycle(CycleRecord& record) noexcept;

  /// Ends a run, wherever it stands: bus cycles until no torque is commanded, at most shut_down_limit_s of
  /// bus time; then drives disabled, nodes pre-operational, and these frames on the wires. The engine stays
  /// as it is.
  void shut_down() noexcept;

  const SceneConfig& scene() const noexcept { return scene_; }
  const Engine& engine() const noexcept { return *engine_; }
  /// Whether there is a body that follows a pose, and so a following error.
  bool follows() const noexcept;
  BusChoice bus() const noexcept { return rig_ ? BusChoice::sim : BusChoice::direct; }
  /// Null without a bus.
  const Rig* rig() const noexcept { return rig_ ? &*rig_ : nullptr; }
  /// Mean load of each simulated bus so far, percent; empty without a bus.
  std::vector<double> bus_load_percent() const;
  /// Time on the buses' clock at which the motion begins, after boot().
  Nanoseconds motion_start_ns() const noexcept { return motion_start_ns_; }
  /// Steps are timed by this; by default they are not.
  void set_step_clock(Nanoseconds (*now)() noexcept) noexcept { step_clock_ = now; }
  void set_bus_observer(const BusObserver& observer) noexcept {
    if (sim_rig_) sim_rig_->set_observer(observer);
  }
  /// False when the motion left the workspace of the device.
  bool reachable() const noexcept { return !sim_rig_ || sim_rig_->reachable(); }

 private:
  /// A joint that the device leads, and the device's joints for its coordinates.
  struct ImposedJoint {
    std::size_t body = 0;
    std::size_t num_coordinates = 0;
    std::array<Eigen::Index, 2> device_joints{};
    std::array<bool, 2> turns{};
  };

  Session(const SceneConfig& scene, Motion motion) : scene_(scene), motion_(std::move(motion)) {}

  double motion_time(std::uint64_t cycle) const noexcept { return static_cast<double>(cycle) * scene_.step; }
  void find_imposed_joints(std::vector<std::string>& errors);
  BodySample motion_sample(std::size_t driven, double t) const noexcept;
  DeviceSample exchange(double motion_time) noexcept;
  void impose(const JointTarget& device, bool valid, std::span<BodySample> samples) const noexcept;
  bool commands_torque() const noexcept;
  void sense(double t) noexcept;
  void sense_through_rig(double t) noexcept;
  void grip(double t) noexcept;
  void act(CycleRecord& record) noexcept;
  void observe(CycleRecord& record) const noexcept;
  void measure(CycleRecord& record) const noexcept;

  SceneConfig scene_;
  Motion motion_;
  std::vector<std::size_t> driven_;  // bodies with a target
  std::vector<std::size_t> held_;    // with a bus: the body of each handle
  std::optional<Grip>
      grip_;  // of a device that takes hold of bodies; the first driven body's samples are its
  std::vector<ImposedJoint> imposed_;
  std::vector<BodySample> samples_;        // one per body, as the core gets them
  std::vector<BodySample> exact_samples_;  // the same with the handle as it really is
  std::unique_ptr<Engine> engine_;
  std::unique_ptr<Engine> exact_engine_;  // runs beside it on exact_samples_, with a bus only
  std::unique_ptr<SimRig> sim_rig_;
  std::optional<Rig> rig_;
  Nanoseconds (*step_clock_)() noexcept = []() noexcept { return Nanoseconds{0}; };
  Nanoseconds period_ns_ = 0;
  Nanoseconds t_bus_ns_ = 0;  // bus time at the start of this cycle
  Nanoseconds t_now_ns_ = 0;  // bus time after the answers to SYNC
  Nanoseconds motion_start_ns_ = 0;
  std::uint64_t cycle_ = 0;
};

}  // namespace godobject
