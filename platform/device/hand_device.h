// What a session's bodies follow: a motion handed over, a rig on its buses, trackers. Each is one file; a new one is one
// more.
#pragma once

#include <optional>
#include <span>

#include "hal/can/frame.h"
#include "platform/engine/engine.h"
#include "platform/motion/motion.h"

namespace godobject {

/// One period of a run, as the devices of a session go through it in their order.
struct Period {
  double t = 0;            // of the motion, s
  double step = 0;         // s
  Nanoseconds began = 0;   // of the devices' clock: when it began
  Nanoseconds now = 0;     // and after the answers to it
  bool has_begun = false;  // a device's clock has said when

  /// For devices that have no clock of their own: by this one, or, where that is null, a step after the period before.
  void begin_by(Nanoseconds (*clock)() noexcept) noexcept {
    if (has_begun) return;
    began = clock != nullptr ? clock() : began + to_ns(step);
    now = began;
    has_begun = true;
  }
};

class HandDevice {
 public:
  virtual ~HandDevice() = default;

  /// One period of booting; real-time, as all that follows.
  virtual void boot(Period&) noexcept {}
  virtual bool ready() const noexcept { return true; }
  /// Once all devices are ready: from now on it may make torque. False: not yet.
  virtual bool arm() noexcept { return true; }
  virtual bool failed() const noexcept { return false; }

  /// Writes what it knows of the hand into the bodies' samples, over what the devices before it have written.
  virtual void read(Period& period, std::span<BodySample> samples) noexcept = 0;

  /// Where the device takes hold of bodies: which it wants. Nothing: what the motion says.
  virtual std::optional<HoldWish> hold() const noexcept { return std::nullopt; }
  /// Its button that takes hold of the nearest body, or lets go, went down in this period.
  virtual bool hold_pressed() const noexcept { return false; }
};

}  // namespace godobject
