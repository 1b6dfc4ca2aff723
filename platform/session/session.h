// A running scene: an engine, and the devices that its bodies follow. A real-time loop calls advance() once
// per period, from the first NMT command to the last. advance() does not allocate and waits only for answers
// of real buses.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "platform/device/hand_device.h"
#include "platform/device/rig.h"
#include "platform/device/trackers.h"
#include "platform/engine/engine.h"
#include "platform/rt/loop_calls.h"
#include "platform/rt/stages.h"
#include "platform/scene/toml.h"
#include "platform/session/grip.h"
#include "platform/session/record.h"
#include "platform/session/world.h"

namespace godobject {

enum class BusChoice : std::uint8_t {
  sim,     // simulated encoders, wires, drives and trackers
  direct,  // no device: the motion drives the core
  real,    // encoders, drives and trackers of a real device
};

/// Parts of a device, real or simulated.
struct DeviceParts {
  std::unique_ptr<RigLink> buses;                      // null for a device without buses
  std::vector<std::unique_ptr<TrackerLink>> trackers;  // in the order of the scene's trackers
  // clock of buses and trackers; null: one step per period
  LoopClock clock = nullptr;
  std::unique_ptr<Truth> truth;  // exact state of a simulated device, else null
};

class Session {
 public:
  struct Made {
    std::unique_ptr<Session> session;  // null: see errors
    std::vector<std::string> errors;
  };
  /// Makes a session without a device: the motion drives the core.
  static Made make(SceneConfig scene, Motion motion);
  /// Makes a session on these buses, which may still be closed but must be open before start().
  /// The motion then moves no body that has a handle of the device; its switches count.
  /// For a simulated device see platform/simulated/session.h.
  static Made make(SceneConfig scene, Motion motion, std::unique_ptr<RigLink> buses);
  static Made make(SceneConfig scene, Motion motion, DeviceParts device);
  Session(const Session&) = delete;  // the devices refer to scene_
  Session& operator=(const Session&) = delete;

  /// Adds a device, which overwrites the samples of those before it. Call it before start(). The device must
  /// outlive the session. Allocates.
  void add(HandDevice& device) { phases_.add(device); }

  /// Adds the planes of another simulation, of this session's scene and engine. Call it before start(). They
  /// must outlive the session.
  void add(WorldPlanes& world) noexcept { world_ = &world; }
  /// Returns the planes of another simulation; null without one.
  const WorldPlanes* world() const noexcept { return world_; }

  /// Enters booting from off, or running if there is neither bus nor tracker.
  /// limit_s: bus time after which booting fails, s; the slowest tracker may prolong it.
  void start(double limit_s) noexcept { phases_.start(limit_s); }
  /// Runs one period of the present phase. Returns true if the period was a step, which is then recorded.
  /// Real-time, for a record from at_start().
  bool advance(CycleRecord& record) noexcept GODOBJECT_NONBLOCKING;
  /// Marks all samples as invalid from the next step on, until hold(false): the pose is held and the force
  /// fades. For a loop that keeps too few of its deadlines.
  void hold(bool on) noexcept { on_hold_ = on; }
  /// Latches the fault that the loop missed so many deadlines in a row that the drives had no command.
  void deadlines_missed() noexcept;
  bool missed_deadlines() const noexcept { return deadlines_missed_; }
  /// Enters running_down from booting or running. Enters ended if there is no bus or the session has not
  /// started.
  void stop() noexcept { phases_.stop(); }
  /// stop() without running down: in the next period each drive removes its torque by its own fastest means,
  /// then it is disabled.
  void quick_stop() noexcept { phases_.quick_stop(); }
  RunPhase phase() const noexcept { return phases_.phase(); }
  /// Returns the state of the run, see docs/faults.md; of a step: armed, hold or fault.
  RigState state() const noexcept { return phases_.supervisor().state(); }
  /// Enters off from ended, with a new rig: start() boots the nodes again. The engine keeps its state, and
  /// the device engages again with the ramp. Allocates.
  void restart();

  /// Calls start() and runs periods up to the first step, for buses with simulated time. Returns true if the
  /// device is ready.
  [[nodiscard]] bool boot(double limit_s);
  /// Calls stop() and runs periods to the end: at most shut_down_limit_s of bus time until no torque is
  /// commanded.
  void shut_down() noexcept;

  /// Returns the state before the first step. Allocates.
  CycleRecord at_start() const;
  /// Runs one step, in RunPhase::running. Real-time, for a record from at_start().
  void cycle(CycleRecord& record) noexcept GODOBJECT_NONBLOCKING;

  const SceneConfig& scene() const noexcept { return scene_; }
  const Motion& motion() const noexcept { return motion_; }
  const Engine& engine() const noexcept { return *engine_; }
  /// True if a body follows a pose, so that there is a following error.
  bool follows() const noexcept;
  /// Returns the distance of a body from its target at the start of the run. None if no target pulls the
  /// body, or if the target is still unknown (real buses).
  std::optional<PoseError> offset_at_start(std::size_t body) const noexcept;
  /// Returns the start of a motion of the device's joints; none for other motions and on real buses.
  std::optional<JointTarget> joints_at_start() const noexcept;
  BusChoice bus() const noexcept {
    if (!phases_.boots()) return BusChoice::direct;
    return truth_ ? BusChoice::sim : BusChoice::real;
  }
  /// Returns the rig; null without a bus.
  const Rig* rig() const noexcept { return rig_ ? &rig_->rig() : nullptr; }
  /// Returns the tracked poses; null without trackers.
  const TrackedPoses* trackers() const noexcept { return trackers_ ? &trackers_->poses() : nullptr; }
  /// Returns sums over all rigs so far: see restart().
  RigCounters rig_counters() const noexcept { return rig_ ? rig_->counters() : RigCounters{}; }
  /// Returns the host's ends of the buses; empty without a bus.
  std::span<CanBus* const> host_buses() const noexcept {
    return rig_ ? rig_->buses() : std::span<CanBus* const>{};
  }
  /// Returns the exact state of a simulated device; null for any other.
  const Truth* truth() const noexcept { return truth_.get(); }
  /// Start of the present or last period on the clock of buses and trackers; 0 without either.
  Nanoseconds bus_time_ns() const noexcept { return phases_.period().began; }
  /// Start of the motion, after the first boot, on the same clock.
  Nanoseconds motion_start_ns() const noexcept { return motion_start_ns_; }
  /// Sets the clock that times the stages of cycles. They are not timed without one.
  void set_stage_clock(LoopClock now) noexcept { phases_.period().stages.set_clock(now); }
  /// Ends the last stage of a step, `observe`, which cycle() begins. Returns the times of its stages.
  const StageTimes& end_stages() noexcept { return phases_.period().stages.stop(); }
  /// Makes records list their contacts. Call it before at_start().
  void list_contacts() noexcept { lists_contacts_ = true; }
  /// Makes records list the inputs of the engine and its hash. Call it before at_start().
  void list_inputs() noexcept { lists_inputs_ = true; }
  /// Makes records list the nodes of their nets. Call it before at_start().
  void list_net_nodes() noexcept { lists_net_nodes_ = true; }
  void set_bus_observer(const BusObserver& observer) noexcept {
    if (rig_) rig_->link().set_observer(observer);
  }
  /// Records the inputs of the rig, if there is one. Call it before start().
  void record_rig(const LinkEventSink& sink) noexcept {
    if (rig_) rig_->record(sink);
  }

 private:
  Session(SceneConfig scene, Motion motion);

  /// device: null for none.
  static Made build(SceneConfig scene, Motion motion, DeviceParts* device);
  void connect(DeviceParts device, std::vector<std::string>& errors);

  // stages of a period, in this order: see cycle()
  void read() noexcept;
  void check() noexcept;
  void step(CycleRecord& record) noexcept;
  void limit(CycleRecord& record) noexcept;
  void command(CycleRecord& record) noexcept;
  void observe(CycleRecord& record) const noexcept;
  void observe_device(CycleRecord& record) const noexcept;
  std::span<const std::size_t> followed() const noexcept;

  void update_grip() noexcept;
  void pass_missed_time() noexcept;
  double motion_time() const noexcept { return static_cast<double>(cycle_) * scene_.step; }

  const SceneConfig scene_;  // the only copy of a run: the devices refer to it
  Motion motion_;
  std::vector<std::size_t> driven_;  // bodies with a target
  JointCoordinatesOf joint_coordinates_;
  std::unique_ptr<Engine> engine_;
  std::vector<BodySample> samples_;  // one per body, as passed to the core
  std::vector<Wrench> F_hand_W_;     // displayed wrench, one per body

  // The devices; each overwrites the samples of those before it.
  HandedMotion handed_;
  std::optional<RigDevice> rig_;
  std::optional<TrackerDevice> trackers_;
  DevicePhases phases_;
  WorldPlanes* world_ = nullptr;
  std::optional<Grip> grip_;  // grip of a device that grips bodies; it uses the first driven body's samples

  /// Position of the device in its last valid sample, world; NaN before the first, which no body is near to.
  Vec3 p_WD_ = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());

  std::optional<WrenchSwings> swings_;
  std::unique_ptr<Truth> truth_;  // exact state of a simulated device
  bool disengages_ = false;       // true after restart(): disengages all bodies for the next step
  bool on_hold_ = false, deadlines_missed_ = false;
  bool lists_contacts_ = false, lists_net_nodes_ = false, lists_inputs_ = false;
  bool real_ = false;  // a real device, with real time
  Nanoseconds motion_start_ns_ = 0;
  std::uint64_t cycle_ = 0;
  double passed_s_ = 0;  // time passed to the engine before this step
};

/// Errors and warnings about the start of a session; no file is named in them.
struct StartCheck {
  std::vector<std::string> errors, warnings;
};

/// Checks the distance of each body from its target at the start, since the coupling would fling it there.
/// Warns above 0.1 m or 0.5 rad; fails above 1 m or 3 rad, of which millimetres or degrees are the usual
/// cause. Does nothing on real buses, whose device reports its pose later.
StartCheck check_start(const Session& session);

/// Interface to a simulation of the scene's device. Code that runs scenes links no simulation; a program that
/// links one passes this. platform/simulated/session.h implements it. Default: no simulator; runs then use
/// real devices or none.
struct SimulatedDevices {
  FaultChecks faults{};
  /// Makes a session on the simulated device of the scene. profiles: profiles of the simulated nodes.
  Session::Made (*make_session)(SceneConfig scene, Motion motion, const RigProfiles& profiles) = nullptr;
  /// Makes the scene's tracker with a simulated far end at rest, for checks. Returns null with errors.
  std::unique_ptr<TrackerLink> (*make_resting_tracker)(const TrackerParams& params,
                                                       std::vector<std::string>& errors) = nullptr;
};

}  // namespace godobject
