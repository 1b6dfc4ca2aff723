// A running scene: an engine, and the devices that its bodies follow. advance() is what a real-time loop calls once per
// period, from the first NMT command to the last; it does not allocate, and waits only for the answers of real buses.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "platform/device/handed_motion.h"
#include "platform/device/phases.h"
#include "platform/device/rig.h"
#include "platform/device/trackers.h"
#include "platform/engine/engine.h"
#include "platform/session/grip.h"
#include "platform/session/joint_coordinates.h"
#include "platform/session/record.h"
#include "platform/session/truth.h"
#include "platform/session/wrench_swings.h"

namespace godobject {

enum class BusChoice : std::uint8_t {
  sim,     // through simulated encoders, wires and drives, and simulated trackers
  direct,  // the motion is handed to the core as it is
  real,    // through the encoders and drives of a device, and its trackers
};

/// What a device has, on this machine or simulated.
struct DeviceParts {
  std::unique_ptr<RigLink> buses;                      // null for a device without any
  std::vector<std::unique_ptr<TrackerLink>> trackers;  // in the order of the scene's
  Nanoseconds (*clock)() noexcept = nullptr;           // that of both; null: a step a period
  std::unique_ptr<Truth> truth;                        // of a simulated device
};

class Session {
 public:
  struct Made {
    std::unique_ptr<Session> session;  // null: see errors
    std::vector<std::string> errors;
  };
  /// Without a device: the motion, which is moved in, is handed to the core as it is.
  static Made make(const SceneConfig& scene, Motion motion);
  /// On buses, which may still be closed: to be opened before start(). The motion then moves nothing that the device has a
  /// handle for; its switches count. A simulated device is made by platform/simulated/session.h.
  static Made make(const SceneConfig& scene, Motion motion, std::unique_ptr<RigLink> buses);
  static Made make(const SceneConfig& scene, Motion motion, DeviceParts device);

  /// One more device, which writes over what the others say. Before start(); it outlives the session. Allocates.
  void add(HandDevice& device) { phases_.add(device); }

  /// off -> booting, given up after `limit_s` of bus time, or that of the slowest tracker; without a bus and a
  /// tracker -> running.
  void start(double limit_s) noexcept { phases_.start(limit_s); }
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
  void stop() noexcept { phases_.stop(); }
  /// stop() without running down: with the next period each drive gets rid of its torque by its own fastest means,
  /// then it is disabled.
  void quick_stop() noexcept { phases_.quick_stop(); }
  RunPhase phase() const noexcept { return phases_.phase(); }
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
  /// How far a body is from the target that pulls it as soon as the run begins. None: nothing pulls it then, or on real buses
  /// nobody knows yet.
  std::optional<PoseError> offset_at_start(std::size_t body) const noexcept;
  /// Where the motion is one of the device's joints.
  std::optional<JointTarget> joints_at_start() const noexcept;
  BusChoice bus() const noexcept {
    if (!phases_.boots()) return BusChoice::direct;
    return truth_ ? BusChoice::sim : BusChoice::real;
  }
  /// Null without a bus.
  const Rig* rig() const noexcept { return rig_ ? &rig_->rig() : nullptr; }
  /// Null without trackers.
  const TrackedPoses* trackers() const noexcept { return trackers_ ? &trackers_->poses() : nullptr; }
  /// Sums over all rigs so far: see restart().
  RigCounters rig_counters() const noexcept { return rig_ ? rig_->counters() : RigCounters{}; }
  /// The host's ends; none without a bus.
  std::span<CanBus* const> host_buses() const noexcept {
    return rig_ ? rig_->buses() : std::span<CanBus* const>{};
  }
  /// Null where the device is none that is simulated.
  const Truth* truth() const noexcept { return truth_.get(); }
  /// Time on the buses' and the trackers' clock at which this period began, or the last one; 0 without either.
  Nanoseconds bus_time_ns() const noexcept { return phases_.period().began; }
  /// The same at which the motion began, after the first boot.
  Nanoseconds motion_start_ns() const noexcept { return motion_start_ns_; }
  /// Steps are timed by this; by default they are not.
  void set_step_clock(Nanoseconds (*now)() noexcept) noexcept { step_clock_ = now; }
  /// Records list their contacts from here on; before at_start().
  void list_contacts() noexcept { lists_contacts_ = true; }
  /// Likewise the nodes of their nets.
  void list_net_nodes() noexcept { lists_net_nodes_ = true; }
  void set_bus_observer(const BusObserver& observer) noexcept {
    if (rig_) rig_->link().set_observer(observer);
  }

 private:
  Session(const SceneConfig& scene, Motion motion);

  /// device: null for none.
  static Made build(const SceneConfig& scene, Motion motion, DeviceParts* device);
  void connect(DeviceParts device, std::vector<std::string>& errors);

  // one period, in this order: see cycle()
  void read() noexcept;
  void check() noexcept;
  void step(CycleRecord& record) noexcept;
  void limit(CycleRecord& record) noexcept;
  void command(CycleRecord& record) noexcept;
  void observe(CycleRecord& record) const noexcept;
  void observe_device(CycleRecord& record) const noexcept;
  std::span<const std::size_t> followed() const noexcept;

  void take_hold() noexcept;
  void pass_missed_time() noexcept;
  double motion_time() const noexcept { return static_cast<double>(cycle_) * scene_.step; }

  SceneConfig scene_;
  Motion motion_;
  std::vector<std::size_t> driven_;  // bodies with a target
  JointCoordinatesOf joint_coordinates_;
  std::unique_ptr<Engine> engine_;
  std::vector<BodySample> samples_;  // one per body, as the core gets them
  std::vector<Wrench> F_hand_W_;     // likewise: what the hand feels of it

  // The devices, each writing over what those before it say.
  HandedMotion handed_;
  std::optional<RigDevice> rig_;
  std::optional<TrackerDevice> trackers_;
  DevicePhases phases_;
  std::optional<Grip>
      grip_;  // of a device that takes hold of bodies; the first driven body's samples are its

  /// The device in its last valid sample, world; not a number before the first: no body is near it.
  Vec3 p_WD_ = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());

  std::optional<WrenchSwings> swings_;
  std::unique_ptr<Truth> truth_;  // of a simulated device
  bool let_go_ = false;           // for the next step: what was held is engaged anew
  bool on_hold_ = false, deadlines_missed_ = false;
  bool lists_contacts_ = false, lists_net_nodes_ = false;
  bool real_ = false;  // the device is one, and time passes by itself
  Nanoseconds (*step_clock_)() noexcept = []() noexcept { return Nanoseconds{0}; };
  Nanoseconds motion_start_ns_ = 0;
  std::uint64_t cycle_ = 0;
};

}  // namespace godobject
