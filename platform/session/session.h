// A running scene: engine, motion, and the rig on its buses and the trackers, simulated or real. advance() is what a real-time
// loop calls once per period, from the first NMT command to the last; it does not allocate, and waits only for
// the answers of real buses.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "hal/rig/rig.h"
#include "platform/engine/engine.h"
#include "platform/session/force_swings.h"
#include "platform/session/grip.h"
#include "platform/session/motion.h"
#include "sim/rig/link.h"
#include "sim/tracker/trackers.h"
#include "platform/session/tracked_poses.h"

namespace godobject {

enum class BusChoice : std::uint8_t {
  sim,     // through simulated encoders, wires and drives, and simulated trackers
  direct,  // the motion is handed to the core as it is
  real,    // through the encoders and drives of a device, and its trackers
};

inline constexpr double shut_down_limit_s = 2;

/// What a period is for. A run goes through them in this order; a fault or stop() leaves some out.
enum class RunPhase : std::uint8_t {
  off,
  booting,       // the nodes come up, the hand of a simulated rig at rest
  running,       // motion and steps
  running_down,  // torque runs down to zero
  closing,       // drives disabled, nodes pre-operational: their frames leave
  ended,
};

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
  // Of an engine beside it that is told the handle exactly; zero without a simulated bus.
  PoseError exact_following;  // its body against the handle
  PoseError encoders;         // body against its body
  double energy = 0;          // J, see Engine::energy()
  // Contacts that bear a force, with room for all that can; no room unless the session lists them.
  std::vector<ContactView> touching;
  std::size_t num_touching = 0;
  Nanoseconds step_ns = 0;  // the engine's step alone, by the step clock
};

/// What a device has on this machine.
struct RealDevice {
  std::unique_ptr<RigLink> buses;                      // null for a device without any
  std::vector<std::unique_ptr<TrackerLink>> trackers;  // in the order of the scene's
  Nanoseconds (*clock)() noexcept = nullptr;           // that of both
};

class Session {
 public:
  struct Made {
    std::unique_ptr<Session> session;  // null: see errors
    std::vector<std::string> errors;
  };
  /// The motion is moved in. bus: sim or direct. profiles: by which the simulated nodes have been set up.
  static Made make(const SceneConfig& scene, Motion motion, BusChoice bus, RigProfiles profiles = {});
  /// On real buses, which may still be closed: to be opened before start(). The motion then moves nothing that
  /// the device has a handle for; its switches count.
  static Made make(const SceneConfig& scene, Motion motion, std::unique_ptr<RigLink> buses);
  static Made make(const SceneConfig& scene, Motion motion, RealDevice device);

  /// off -> booting, given up after `limit_s` of bus time, or that of the slowest tracker; without a bus and a
  /// tracker -> running.
  void start(double limit_s) noexcept;
  /// One period, whatever it is for; real-time, for a record that comes from at_start(). True: it was a step,
  /// and the record is of it.
  bool advance(CycleRecord& record) noexcept;
  /// The loop keeps too few of its deadlines: from the next step on, until told otherwise, no sample counts; the pose is
  /// held and the force fades.
  void hold(bool on) noexcept { on_hold_ = on; }
  /// It has missed so many in a row that the drives had no command: sticky, as any fault of the rig, or of the run
  /// without one.
  void deadlines_missed() noexcept;
  bool missed_deadlines() const noexcept { return deadlines_missed_; }
  /// booting, running -> running_down; without a bus, or before start() -> ended.
  void stop() noexcept;
  /// stop() without running down: with the next period each drive gets rid of its torque by its own fastest means,
  /// then it is disabled.
  void quick_stop() noexcept;
  RunPhase phase() const noexcept { return phase_; }
  /// ended -> off, with a rig that knows nothing of what was: start() boots the nodes afresh. The engine stays
  /// as it is; what the device held is engaged anew, by the ramp. Allocates.
  void restart();

  /// start(), and periods up to the first step: for buses whose time does not pass by itself. True when the
  /// device is ready.
  [[nodiscard]] bool boot(double limit_s);
  /// stop(), and periods to the end: at most shut_down_limit_s of bus time until no torque is commanded.
  void shut_down() noexcept;

  /// The state before the first step. Allocates.
  CycleRecord at_start() const;
  /// One step. Real-time, for a record that comes from at_start(), in RunPhase::running.
  void cycle(CycleRecord& record) noexcept;

  const SceneConfig& scene() const noexcept { return scene_; }
  const Engine& engine() const noexcept { return *engine_; }
  /// Whether there is a body that follows a pose, and so a following error.
  bool follows() const noexcept;
  /// Of a body to the target that pulls it as soon as the run begins. None: nothing pulls it then, or on real buses
  /// nobody knows yet.
  std::optional<PoseError> offset_at_start(std::size_t body) const noexcept;
  /// Where the motion is one of the device's joints.
  std::optional<JointTarget> joints_at_start() const noexcept;
  BusChoice bus() const noexcept { return rig_ || tracked_ ? bus_ : BusChoice::direct; }
  /// Null without a bus.
  const Rig* rig() const noexcept { return rig_ ? &*rig_ : nullptr; }
  /// Null without trackers.
  const TrackedPoses* trackers() const noexcept { return tracked_ ? &*tracked_ : nullptr; }
  /// Of all rigs so far: see restart().
  RigCounters rig_counters() const noexcept;
  /// The host's ends; none without a bus.
  std::span<CanBus* const> host_buses() const noexcept {
    return link_ ? link_->buses() : std::span<CanBus* const>{};
  }
  /// Mean load of each simulated bus so far, percent; empty without one.
  std::vector<double> bus_load_percent() const;
  /// Time on the buses' and the trackers' clock at which this period began, or the last one; 0 without either.
  Nanoseconds bus_time_ns() const noexcept { return t_bus_ns_; }
  /// The same at which the motion began, after the first boot.
  Nanoseconds motion_start_ns() const noexcept { return motion_start_ns_; }
  /// Steps are timed by this; by default they are not.
  void set_step_clock(Nanoseconds (*now)() noexcept) noexcept { step_clock_ = now; }
  /// Records list their contacts from here on; before at_start().
  void list_contacts() noexcept { lists_contacts_ = true; }
  void set_bus_observer(const BusObserver& observer) noexcept {
    if (link_) link_->set_observer(observer);
  }
  /// False when the motion left the workspace of the simulated device.
  bool reachable() const noexcept { return !sim_ || sim_->rig().reachable(); }

 private:
  /// A joint that the device leads, and the device's joints for its coordinates.
  struct ImposedJoint {
    std::size_t body = 0;
    std::size_t num_coordinates = 0;
    std::array<Eigen::Index, 2> device_joints{};
    std::array<bool, 2> turns{};
  };

  Session(const SceneConfig& scene, Motion motion);

  static Made make(const SceneConfig& scene, Motion motion, BusChoice bus, RealDevice device,
                   const RigProfiles& profiles);
  void take_motion_at_start();
  void connect(RealDevice device, const RigProfiles& profiles, std::vector<std::string>& errors);
  void connect_rig(std::unique_ptr<RigLink> buses, const RigProfiles& profiles,
                   std::vector<std::string>& errors);
  void connect_trackers(RealDevice device, std::vector<std::string>& errors);
  void find_imposed_joints(bool real, std::vector<std::string>& errors);

  // session_phases.cc
  void boot_cycle() noexcept;
  void run_down_cycle() noexcept;
  void closing_cycle() noexcept;
  void give_up_running() noexcept;
  bool device_ready() noexcept;
  bool device_failed() const noexcept;
  void pass_period() noexcept;
  void track() noexcept;
  DeviceSample exchange() noexcept;
  CommandReport command(std::span<const Wrench> F_hand_W) noexcept;
  void take_in() noexcept;
  bool commands_torque() const noexcept;

  double motion_time(std::uint64_t cycle) const noexcept { return static_cast<double>(cycle) * scene_.step; }
  BodySample motion_sample(std::size_t driven, double t) const noexcept;
  void impose(const JointTarget& device, bool valid, std::span<BodySample> samples) const noexcept;
  void pass_missed_time(Nanoseconds t_before) noexcept;
  void sense(double t) noexcept;
  void sense_through_rig() noexcept;
  void sense_through_trackers() noexcept;
  void grip(double t) noexcept;
  void act(CycleRecord& record) noexcept;
  void watch_force(CycleRecord& record) noexcept;
  void observe(CycleRecord& record) const noexcept;
  void measure(CycleRecord& record) const noexcept;

  SceneConfig scene_;
  Motion motion_;
  std::vector<std::size_t> driven_;  // bodies with a target
  std::vector<std::size_t> held_;    // with a bus: the body of each handle
  std::optional<Grip>
      grip_;  // of a device that takes hold of bodies; the first driven body's samples are its
  DeviceButtons buttons_, buttons_before_;  // of the device; pressed in this step and in the one before
  std::vector<ImposedJoint> imposed_;
  std::vector<BodySample> samples_;        // one per body, as the core gets them
  std::vector<BodySample> exact_samples_;  // the same with the handle as it really is
  std::unique_ptr<Engine> engine_;
  std::unique_ptr<Engine> exact_engine_;  // runs beside it on exact_samples_, with a bus only
  std::unique_ptr<RigLink> link_;
  const SimLink* sim_ = nullptr;  // the link, where that is simulated
  BusChoice bus_ = BusChoice::sim;
  std::vector<std::size_t> tracked_bodies_;  // of each pose of tracked_
  std::optional<TrackedPoses> tracked_;
  std::optional<SimTrackers> sim_trackers_;    // their far ends, where those are simulated
  Nanoseconds (*clock_)() noexcept = nullptr;  // of real trackers
  std::optional<Rig> rig_;
  std::optional<ForceSwings> swings_;
  RigCounters earlier_rigs_;
  RunPhase phase_ = RunPhase::off;
  std::int64_t periods_left_ = 0;  // of this phase at most
  bool let_go_ = false;            // for the next step: what was held is engaged anew
  bool on_hold_ = false, deadlines_missed_ = false;
  bool lists_contacts_ = false;
  Nanoseconds (*step_clock_)() noexcept = []() noexcept { return Nanoseconds{0}; };
  Nanoseconds gather_ns_ = 0;
  Nanoseconds t_bus_ns_ = 0;  // bus time at the start of this cycle
  Nanoseconds t_now_ns_ = 0;  // bus time after the answers to SYNC
  Nanoseconds motion_start_ns_ = 0;
  std::uint64_t cycle_ = 0;
};

}  // namespace godobject
