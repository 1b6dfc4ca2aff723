// Keys of [[fault]] tables, in scenes and in files of their own. Visitors: platform/scene/text/key.h.
#pragma once

#include <string>
#include <vector>

#include "platform/scene/text/key.h"
#include "platform/scene/toml.h"

namespace godobject {

template <class V>
void visit_fault(V& v, const DeviceConfig* device, const FaultChecks& checks, FaultConfig& f) {
  if (f.verb.empty()) f.verb = "drop";
  const Key verb{.name = "verb", .unit = "", .meaning = "see docs/faults.md", .required = true};
  if (checks.verbs == nullptr) v.value(verb, f.verb);
  else choose(v, verb, checks.verbs(), f.verb);
  v.value(Key{"bus", "", "empty: the node's; without a node all"}, f.bus);
  std::uint8_t node_id = f.node_id.value_or(0);
  v.value(Key{"node_id", "", "0: the host's end of the bus", {0, 127}}, node_id);
  f.node_id = node_id == 0 ? std::nullopt : std::optional(node_id);
  v.value(Key{"tracker", "", "instead of bus and node"}, f.tracker);
  v.value(Key{"at", "s", "time of the motion; at 0 it is active from booting", {0, 1e6}}, f.at);
  v.value(Key{"duration",
              "s",
              "default: to the end, or once for an event",
              {.min = 0, .max = 1e6, .min_open = true}},
          f.duration);
  v.value(Key{"value", "", "unit in docs/faults.md; 0: the verb's default"}, f.value);
  const bool has_place = device && (device->rig || !f.tracker.empty());
  v.check(has_place, "verb", "requires a [device] with buses, or a tracker: add one, or remove the fault");
  if (!has_place || checks.why_not_playable == nullptr) return;
  const std::string error = checks.why_not_playable(f, *device);
  v.check(error.empty(), "verb", "'" + f.verb + "' cannot be played: " + error);
}

}  // namespace godobject
