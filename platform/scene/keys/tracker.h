// All keys below [[device.tracker]] of a scene file. Visitors: platform/scene/text/key.h.
#pragma once

#include <set>

#include "hal/tracker/tracker.h"
#include "platform/scene/scene.h"
#include "platform/scene/text/key.h"

namespace godobject {

/// bodies: names of those that can have a target.
template <class V>
void visit_tracked_tool(V& v, const std::vector<std::string>& bodies, TrackedToolParams& t) {
  choose(v, Key{.name = "body", .unit = "", .meaning = "coupled body whose target it is", .required = true},
         bodies, t.body);
  v.value(Key{.name = "tool",
              .unit = "",
              .meaning = "NDI: port handle as `\"0A\"`, or file of a passive tool (.rom), relative to the "
                         "scene; Polhemus: number of the station",
              .required = true},
          t.tool);
  visit_pose(v, "target_position", "target_orientation_wxyz", "the target on the tool", t.X_TH);
}

template <class V>
void visit_tracker(V& v, const std::vector<std::string>& bodies, std::set<std::string>& tracked,
                   TrackerParams& t) {
  visit_name(v, "name in messages and faults", t.name);
  choose(v, Key{"protocol", "", "ndi: Polaris, Vega, Aurora; polhemus: Fastrak, Liberty, Patriot"},
         tracker_protocol_names, t.protocol);
  v.value(Key{.name = "port",
              .unit = "",
              .meaning = "serial line, best `\"/dev/serial/by-id/...\"`",
              .required = true},
          t.port);
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
  v.tables(TableKey{"tracker", "A tracker on a serial line ([trackers](trackers.md))."}, trackers,
           [&](auto& table, TrackerParams& t) {
             visit_tracker(table, bodies, handled, t);
             table.check(names.insert(t.name).second, "name", "is the name of an earlier tracker");
           });
}

}  // namespace godobject
