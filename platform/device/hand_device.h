// Interface of the devices that a session's bodies follow: a prescribed motion, a rig on its buses, trackers.
// Each device is one file, but for the motion itself as the device. It is here with the samples of prescribed
// joints, which rigs and motions write. DevicePhases runs the phases of devices, for Session and for programs
// with a step of their own.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/nonblocking.h"
#include "hal/can/frame.h"
#include "hal/joint/kinematic_tree.h"
#include "hal/rig/rig.h"
#include "platform/engine/engine.h"
#include "platform/motion/motion.h"
#include "platform/rt/stages.h"
#include "platform/scene/scene.h"

namespace godobject {

/// One period of a run, passed to the devices of a session in their order.
struct Period {
  double t = 0;                  // time of the motion, s
  double step = 0;               // s
  Nanoseconds began_before = 0;  // start of the period before, ns
  Nanoseconds began = 0;         // start of this period on the devices' clock, ns
  Nanoseconds now = 0;           // time after the answers of this period, ns
  bool has_begun = false;        // true if a device has set `began` by its clock
  StageWatch stages{};           // times of this period

  /// Sets the start of the period for devices without a clock of their own.
  /// clock: time source; null: a step after the period before.
  void begin_by(LoopClock clock) noexcept {
    if (has_begun) return;
    began = clock != nullptr ? clock() : began + to_ns(step);
    now = began;
    has_begun = true;
  }
};

/// Outcome of a step's wrenches on a device that displays them.
struct Shown {
  CommandReport drives;
  RigFault faults = RigFault::none;
  bool oscillates = false;  // displayed force oscillates between its bounds; set on entry if the wrenches do
};

/// Trouble of a run that a device must answer.
enum class RunTrouble : std::uint8_t {
  energy_gained,
  deadlines_missed,  // so many in a row that drives had no command
};

class HandDevice {
 public:
  virtual ~HandDevice() = default;

  // Phase before the first step. All functions but boot_limit_s() are real-time, here and below.

  /// Returns the time the device may take to boot, s; the run waits at least as long. None for devices that
  /// need not boot.
  virtual std::optional<double> boot_limit_s() const noexcept GODOBJECT_NONBLOCKING { return std::nullopt; }
  /// Runs one period of booting.
  virtual void boot(Period&) noexcept GODOBJECT_NONBLOCKING {}
  virtual bool ready() const noexcept GODOBJECT_NONBLOCKING { return true; }
  /// Enables torque; called once all devices are ready. Returns false if not possible yet.
  virtual bool arm() noexcept GODOBJECT_NONBLOCKING { return true; }
  virtual bool failed() const noexcept GODOBJECT_NONBLOCKING { return false; }
  /// True while booting waits for the user; the limit for booting does not count this time.
  virtual bool waits_for_user() const noexcept GODOBJECT_NONBLOCKING { return false; }

  // Each period:

  /// Writes the state of the hand into the bodies' samples, over that of the devices before.
  virtual void read(Period& period, std::span<BodySample> samples) noexcept GODOBJECT_NONBLOCKING = 0;
  /// Displays the wrenches to the hand. F_hand_W: one per body, world axes; ignored for bodies without a
  /// device.
  virtual void command(Period&, std::span<const Wrench>, Shown&) noexcept GODOBJECT_NONBLOCKING {}
  virtual void tell(RunTrouble) noexcept GODOBJECT_NONBLOCKING {}

  // For devices that grip bodies:

  /// Body to hold. None: the motion decides.
  virtual std::optional<HoldWish> hold() const noexcept GODOBJECT_NONBLOCKING { return std::nullopt; }
  /// True if the device has a button that grips the nearest body or releases the held one. hold_pressed():
  /// true if it was pressed in this period.
  virtual bool has_hold_button() const noexcept GODOBJECT_NONBLOCKING { return false; }
  virtual bool hold_pressed() const noexcept GODOBJECT_NONBLOCKING { return false; }

  // From the last step to the last period:

  /// True if the device has drives. Their torque must run down before they are switched off.
  virtual bool makes_torque() const noexcept GODOBJECT_NONBLOCKING { return false; }
  /// disarm(): the torque runs down from the next period on. quick_stop(): each drive removes it by its own
  /// fastest means.
  virtual void disarm() noexcept GODOBJECT_NONBLOCKING {}
  virtual void quick_stop() noexcept GODOBJECT_NONBLOCKING {}
  /// Runs one ramp-down period. Returns false once every reachable drive is commanded zero torque.
  virtual bool run_down(Period&) noexcept GODOBJECT_NONBLOCKING { return false; }
  /// Disables drives and sets nodes pre-operational. The frames are sent in the periods of close().
  virtual void stop(Period&) noexcept GODOBJECT_NONBLOCKING {}
  virtual void close(Period&) noexcept GODOBJECT_NONBLOCKING {}
  /// Discards the device's state, so that it boots again. Allocates.
  virtual void restart() {}
};

/// Samples of the prescribed joints of the scene, which follow the device's joints of the same names.
class PrescribedSamples {
 public:
  PrescribedSamples() = default;
  /// Allocates; the other functions do not. scene: each coordinate of its prescribed joints must be a joint
  /// of the device's rig.
  explicit PrescribedSamples(const SceneConfig& scene);

  /// Writes the device's coordinates into the samples of the joints' children. valid: true if the device's
  /// sample is valid.
  /// A joint is engaged with its body's handle, or else with the first driven body's.
  void write(const JointTarget& device, bool valid, std::span<BodySample> samples) const noexcept;

 private:
  struct Joint {
    std::size_t body = 0;  // the joint's child
    bool driven = false;   // true if a handle drives the body
    std::size_t num_coordinates = 0;
    std::array<Eigen::Index, 2> device_joints{};
  };

  std::vector<Joint> joints_;
  std::optional<std::size_t> first_driven_;
};

/// A motion as the device: passes targets, wrenches of the hand and switches to the core unchanged.
class HandedMotion final : public HandDevice {
 public:
  /// Allocates; the other functions do not. motion: a motion of this scene, which must outlive this object.
  HandedMotion(const SceneConfig& scene, const Motion& motion)
      : motion_(motion),
        driven_(driven_bodies(scene)),
        joints_(motion.has_joints() ? PrescribedSamples(scene) : PrescribedSamples()) {}

  void read(Period& period, std::span<BodySample> samples) noexcept override {
    for (std::size_t i = 0; i < motion_.num_bodies(); ++i) samples[driven_[i]] = sample(i, period.t);
    write_joints(period.t, samples);
  }

  /// Writes the prescribed joints' coordinates, if the motion is one of the device's joints.
  void write_joints(double t, std::span<BodySample> samples) const noexcept {
    if (motion_.has_joints()) joints_.write(motion_.joints(t), true, samples);
  }

  /// Returns the sample of the target of this index: see Motion.
  BodySample sample(std::size_t index, double t) const noexcept {
    const MotionSwitches switches = motion_.switches(index, t);
    return {.target = motion_.target(index, t),
            .F_WB = motion_.wrench(index, t),
            .engaged = switches.engaged,
            .clutch = switches.clutch,
            .joint = {}};
  }

 private:
  const Motion& motion_;
  std::vector<std::size_t> driven_;
  PrescribedSamples joints_;
};

/// Least limit for booting, s. A device with a longer one prolongs it: HandDevice::boot_limit_s().
inline constexpr double usual_boot_limit_s = 10;
inline constexpr double shut_down_limit_s = 2;

/// Purpose of a period, by the state of the run. A run passes through these in order; stop() skips some.
enum class RunPhase : std::uint8_t {
  off,
  booting,       // nodes boot; the hand of a simulated rig is at rest
  running,       // motion and steps: armed, hold, fault
  running_down,  // torque runs down to zero: stopping
  closing,       // drives disabled, nodes pre-operational; their frames are sent
  ended,
};
RunPhase phase_of(RigState state) noexcept;

class DevicePhases {
 public:
  /// step: period, s.
  explicit DevicePhases(double step) { period_.step = step; }

  /// Adds a device, which must outlive this object. Devices run each period in the order of adding.
  /// Allocates.
  void add(HandDevice& device) { devices_.push_back(&device); }
  std::span<HandDevice* const> devices() const noexcept { return devices_; }

  /// Enters booting from off, or running if no device boots.
  /// limit_s: time after which booting fails, s; the slowest device may prolong it.
  void start(double limit_s) noexcept;
  /// Runs one period that is no step. t: time of the motion, s.
  void advance(double t) noexcept;
  /// Starts a period that is a step. t: time of the motion, s.
  Period& begin(double t) noexcept;
  /// Enters running_down from booting or running. Enters ended if no device makes torque, or before start().
  void stop() noexcept;
  /// stop() without running down.
  void quick_stop() noexcept;
  /// Enters off from ended; the devices discard their state. Allocates.
  void restart();

  /// Enters hold, or armed again.
  void hold(bool pose_is_lost) noexcept {
    static_cast<void>(supervisor_.on(pose_is_lost ? RigEvent::pose_lost : RigEvent::pose_back));
  }
  /// Enters fault from a step, until stop().
  void fault() noexcept {
    if (phase() == RunPhase::running) static_cast<void>(supervisor_.on(RigEvent::fault));
  }

  RunPhase phase() const noexcept { return phase_of(supervisor_.state()); }
  /// Returns the state of the run; of a step: armed, hold or fault.
  const Supervisor& supervisor() const noexcept { return supervisor_; }
  const Period& period() const noexcept { return period_; }
  Period& period() noexcept { return period_; }
  bool makes_torque() const noexcept;
  bool boots() const noexcept;

 private:
  void boot(Period& period) noexcept;
  void arm() noexcept;
  void run_down(Period& period) noexcept;
  void close(Period& period) noexcept;
  void give_up_running() noexcept;
  std::int64_t periods(double time_s) const noexcept;

  std::vector<HandDevice*> devices_;
  Period period_;
  Supervisor supervisor_;
  std::int64_t periods_left_ = 0;  // maximum for the present phase
};

}  // namespace godobject
