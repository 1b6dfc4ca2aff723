// Keys of the hand's devices: [[device.tracker]], [device.spacemouse], and those by which a device grips and
// releases bodies. Visitors: platform/scene/text/key.h.
#pragma once

#include <algorithm>
#include <set>

#include "hal/tracker/address.h"
#include "hal/tracker/spacenav.h"
#include "hal/tracker/tracker.h"
#include "platform/scene/scene.h"
#include "platform/scene/text/key.h"

namespace godobject {

// Gripping.

/// Returns why a body of this name cannot be held; empty if it can.
inline std::string why_not_held(const SceneConfig& scene, const std::string& name) {
  const auto of_name = [&](const BodyConfig& b) { return b.name == name; };
  const auto body = std::ranges::find_if(scene.bodies, of_name);
  if (body == scene.bodies.end()) return "is \"" + name + "\", which is not a body of the scene";
  if (!body->coupling) return "is \"" + name + "\", which has no [body.coupling]: add it";
  return "";
}

template <class V>
void check_held(V& v, const SceneConfig& scene, std::string_view key, const std::string& name) {
  const std::string why_not = name.empty() ? "" : why_not_held(scene, name);
  v.check(why_not.empty(), key, why_not);
}

template <class V>
void visit_grabbing(V& v, const SceneConfig& scene, DeviceConfig& d) {
  v.value(Key{"holds", "", "body held at the start; see Gripping above"}, d.holds);
  check_held(v, scene, "holds", d.holds);
  v.value(Key{"grab_radius", "m", "reach of gripping, from the device to a centre of mass", positive},
          d.grab_radius);
}

template <class V>
void visit_holds(V& v, const SceneConfig& scene, std::vector<HoldConfig>& holds) {
  const bool has_radius = scene.device && scene.device->grab_radius;
  double before = -1;
  v.tables(
      TableKey{"hold", "From this time on the device holds this body, at the body's pose.", false, 10'000},
      holds, [&](auto& t, HoldConfig& hold) {
        t.value(Key{"time", "s", "later than that of the previous table", not_negative, true}, hold.time);
        t.check(hold.time > before, "time", "must be later than that of the previous table");
        before = hold.time;
        t.value(Key{"body", "", "coupled body, or \"nearest\" within `grab_radius`; empty: releases"},
                hold.body);
        if (hold.body != nearest_body) return check_held(t, scene, "body", hold.body);
        t.check(has_radius, "body", "is \"nearest\", which requires [device] 'grab_radius': add it");
      });
}

/// Checks rules between the tables of a scene whose device grips bodies.
template <class V>
void check_holding(V& v, const SceneConfig& s) {
  v.check(s.device || !s.motion || s.motion->holds.empty(), "motion",
          "has holds, which require a [device]: add one, or remove the holds");
  if (!grips_bodies(s)) return;
  v.check(s.device->kind != DeviceKind::admittance, "device",
          "of kind \"admittance\" has no pose at which it could hold a body: remove 'holds', 'grab_radius' "
          "and [[motion.hold]]");
  const KinematicTreeParams* const tree = device_tree(s);
  const std::size_t num_handles = tree != nullptr ? tree->handles.size() : 0;
  v.check(num_handles <= 1, "device",
          "grips bodies one at a time and requires one handle, not " + std::to_string(num_handles));
  v.check(!s.device->spacemouse || s.device->grab_radius || !s.device->holds.empty(), "device",
          "has a SpaceMouse, whose button grips bodies and requires 'grab_radius': add it");
  for (const BodyConfig& body : s.bodies)
    v.check(body.name != nearest_body && body.name != "-", "body",
            "'" + body.name + "' is reserved in holds for the nearest body or none: choose another name");
}

// [device.spacemouse].

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

// [[device.tracker]].

/// bodies: names of those that can have a target.
template <class V>
void visit_tracked_tool(V& v, const std::vector<std::string>& bodies, TrackedToolParams& t) {
  choose(v, Key{.name = "body", .unit = "", .meaning = "coupled body whose target it is", .required = true},
         bodies, t.body);
  v.value(Key{.name = "tool",
              .unit = "",
              .meaning = "NDI: port handle as `\"0A\"`, or file of a passive tool (.rom), relative to the "
                         "scene; Polhemus: number of the station; openigtlink: name of the device",
              .required = true},
          t.tool);
  visit_pose(v, "target_position", "target_orientation_wxyz", "the target on the tool", t.X_TH);
}

template <class V>
void visit_tracker(V& v, const std::vector<std::string>& bodies, std::set<std::string>& tracked,
                   TrackerParams& t) {
  visit_name(v, "name in messages and faults", t.name);
  choose(v,
         Key{"protocol", "",
             "ndi: Polaris, Vega, Aurora; polhemus: Fastrak, Liberty, Patriot; openigtlink: a server"},
         tracker_protocol_names, t.protocol);
  v.value(
      Key{.name = "port",
          .unit = "",
          .meaning = "serial line, best `\"/dev/serial/by-id/...\"`, or `\"tcp:HOST:PORT\"`: openigtlink, "
                     "ndi (Vega)",
          .required = true},
      t.port);
  const std::string_view tcp_port = default_tcp_port(t.protocol);
  const bool has_address = parse_tcp_address(t.port, tcp_port).has_value();
  const bool fits =
      is_on_network(t) ? has_address && !tcp_port.empty() : t.protocol != TrackerProtocol::openigtlink;
  v.check(fits, "port",
          "must be tcp:HOST:PORT for openigtlink, that or a serial line for ndi, a serial line for polhemus");
  v.value(Key{"baud", "bit/s", "NDI: after the first contact at 9600", {1200, 4e6}}, t.baud);
  visit_pose(v, "position", "orientation_wxyz", "its frame in the world", t.X_WT);
  v.unit_vector(Key{"hemisphere", "", "Polhemus: from the source towards its sensors, in its frame"},
                t.hemisphere);
  v.value(Key{"stale_after", "s", "age beyond which a pose is invalid", positive}, t.stale_after_s);
  v.value(Key{"boot_timeout", "s", "from opening the line to tracking", positive}, t.boot_timeout_s);
  v.value(Key{"min_cutoff", "Hz", "One-Euro filter: cut-off at rest; 0: no filter", not_negative},
          t.min_cutoff_hz);
  v.value(Key{"cutoff_slope", "1/m", "cut-off added per speed, Hz per m/s", not_negative},
          t.cutoff_slope_s_per_m);
  v.tables(TableKey{.name = "tool", .meaning = "A tracked tool: the target of a body.", .required = true},
           t.tools, [&](auto& table, TrackedToolParams& tool) {
             visit_tracked_tool(table, bodies, tool);
             table.check(tracked.insert(tool.body).second, "body",
                         "is the target of an earlier tool or handle: choose another body");
           });
  v.check(t.tools.size() <= max_tracked_tools, "tool",
          "must be at most " + std::to_string(max_tracked_tools) + " tables, not " +
              std::to_string(t.tools.size()));
}

/// Returns the names of the bodies with a handle of the device's own.
inline std::set<std::string> handled_bodies(const DeviceConfig& device) {
  std::set<std::string> names;
  if (!device.rig) return names;
  for (const HandleParams& handle : device.rig->tree.handles) names.insert(handle.body);
  return names;
}

/// handled: see handled_bodies().
template <class V>
void visit_trackers(V& v, const std::vector<std::string>& bodies, std::set<std::string> handled,
                    std::vector<TrackerParams>& trackers) {
  std::set<std::string> names;
  v.tables(TableKey{"tracker", "A tracker ([trackers](trackers.md))."}, trackers,
           [&](auto& table, TrackerParams& t) {
             visit_tracker(table, bodies, handled, t);
             table.check(names.insert(t.name).second, "name", "is the name of an earlier tracker");
           });
}

}  // namespace godobject
