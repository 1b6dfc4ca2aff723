// Keys by which a device grips and releases bodies. Visitors: platform/scene/text/key.h.
#pragma once

#include <algorithm>

#include "platform/scene/scene.h"
#include "platform/scene/text/key.h"

namespace godobject {

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

}  // namespace godobject
