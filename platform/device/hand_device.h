// What a session's bodies follow: a motion handed over, a rig on its buses, trackers. Each is one file; a new one is one
// more.
#pragma once

#include <optional>
#include <span>

#include "hal/can/frame.h"
#include "hal/rig/rig.h"
#include "platform/engine/engine.h"
#include "platform/motion/motion.h"

namespace godobject {

/// One period of a run, as the devices of a session go through it in their order.
struct Period {
  double t = 0;                  // of the motion, s
  double step = 0;               // s
  Nanoseconds began_before = 0;  // the period before
  Nanoseconds began = 0;         // of the devices' clock: when it began
  Nanoseconds now = 0;           // and after the answers to it
  bool has_begun = false;        // a device's clock has said when

  /// For devices that have no clock of their own: by this one, or, where that is null, a step after the period before.
  void begin_by(Nanoseconds (*clock)() noexcept) noexcept {
    if (has_begun) return;
    began = clock != nullptr ? clock() : began + to_ns(step);
    now = began;
    has_begun = true;
  }
};

/// What became of a step's wrenches on a device that shows them.
struct Shown {
  CommandReport drives;
  RigFault faults = RigFault::none;
  bool oscillates =
      false;  // what is shown has begun to swing between its bounds; set before where wrenches do
};

/// What is wrong with a run that a device has to answer.
enum class RunTrouble : std::uint8_t {
  energy_gained,
  deadlines_missed,  // so many in a row that drives had no command
};

class HandDevice {
 public:
  virtual ~HandDevice() = default;

  // From the first period to the first step; all but boot_limit_s() is real-time, as all that follows.

  /// How long it may take to come up, s: at least so long it is waited for. None: it is up by itself.
  virtual std::optional<double> boot_limit_s() const noexcept { return std::nullopt; }
  /// One period of booting.
  virtual void boot(Period&) noexcept {}
  virtual bool ready() const noexcept { return true; }
  /// Once all devices are ready: from now on it may make torque. False: not yet.
  virtual bool arm() noexcept { return true; }
  virtual bool failed() const noexcept { return false; }

  // Once a period.

  /// Writes what it knows of the hand into the bodies' samples, over what the devices before it have written.
  virtual void read(Period& period, std::span<BodySample> samples) noexcept = 0;
  /// Shows the hand what it is to feel: F_hand_W of each body, of those that follow none it does not matter.
  virtual void command(Period&, std::span<const Wrench>, Shown&) noexcept {}
  virtual void tell(RunTrouble) noexcept {}

  // Where the device takes hold of bodies.

  /// Which it wants. Nothing: what the motion says.
  virtual std::optional<HoldWish> hold() const noexcept { return std::nullopt; }
  /// It has a button that takes hold of the nearest body, or lets go; and that went down in this period.
  virtual bool has_hold_button() const noexcept { return false; }
  virtual bool hold_pressed() const noexcept { return false; }

  // From the last step to the last period.

  /// It has drives: their torque has to run down, and they are switched off.
  virtual bool makes_torque() const noexcept { return false; }
  /// Torque runs down from the next period on; or each drive gets rid of it by its own fastest means.
  virtual void disarm() noexcept {}
  virtual void quick_stop() noexcept {}
  /// One period of running down; false when no drive that can still be told otherwise is commanded torque.
  virtual bool run_down(Period&) noexcept { return false; }
  /// Drives are disabled, nodes go pre-operational: their frames leave in the periods of close().
  virtual void stop(Period&) noexcept {}
  virtual void close(Period&) noexcept {}
  /// It knows nothing of what was, and boots afresh. Allocates.
  virtual void restart() {}
};

}  // namespace godobject
