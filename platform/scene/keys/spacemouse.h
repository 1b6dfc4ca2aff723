// All keys of [device.spacemouse] of a scene file. Visitors: platform/scene/text/key.h.
#pragma once

#include "hal/tracker/spacenav.h"
#include "platform/scene/scene.h"
#include "platform/scene/text/key.h"

namespace godobject {

/// bodies: names of those that can have a target.
template <class V>
void visit_spacemouse(V& v, const std::vector<std::string>& bodies, SpaceMouseConfig& s) {
  if (s.body.empty() && !bodies.empty()) s.body = bodies.front();
  choose(v,
         Key{.name = "body",
             .unit = "",
             .meaning = "coupled body that it moves, or at which gripping starts",
             .otherwise = "the first coupled body"},
         bodies, s.body);
  v.attitude(Key{"orientation_wxyz", "", "its frame in the world: x right, y away from the user, z up"},
             s.q_WM);
  v.value(Key{"max_speed", "m/s", "of the target at full scale", positive}, s.max_speed);
  v.value(Key{"max_turn_rate", "rad/s", "of the target at full scale", positive}, s.max_turn_rate);
  v.value(Key{"full_scale", "", "counts of an axis at its stop", positive}, s.full_scale);
  v.value(Key{"deadband", "", "counts below which an axis rests", not_negative}, s.deadband);
  v.check(s.deadband < s.full_scale, "deadband", "must be below full_scale");
  v.value(Key{"rate", "Hz", "of reports while pushed; after three periods without one the target rests",
              positive},
          s.rate_hz);
  const Range buttons{-1, max_spacenav_button};
  v.value(Key{"clutch_button", "", "opens the clutch while pressed; -1: none", buttons}, s.clutch_button);
  v.value(
      Key{"hold_button", "", "grips the nearest body within `grab_radius`, or releases; -1: none", buttons},
      s.hold_button);
  v.check(s.hold_button < 0 || s.hold_button != s.clutch_button, "hold_button",
          "is also clutch_button: give another number");
}

/// Checks that the device displays no force and that nothing else moves the tool.
template <class V>
void check_spacemouse(V& v, const DeviceConfig& d) {
  v.check(d.kind == DeviceKind::relative || d.kind == DeviceKind::non_haptic, "spacemouse",
          "displays no force: [device] kind must be \"relative\" or \"non-haptic\"");
  v.check(!d.rig && d.trackers.empty(), "spacemouse",
          "moves the tool, and so do the device's encoders and trackers: remove either");
}

}  // namespace godobject
