#include "platform/simulated/session.h"

#include "sim/fault/target.h"

namespace godobject {
namespace {

std::vector<std::string> fault_verb_names() {
  std::vector<std::string> names;
  for (const FaultVerbText& text : fault_verb_texts()) names.emplace_back(text.name);
  return names;
}

}  // namespace

FaultChecks simulated_faults() { return {.verbs = fault_verb_names, .why_not_playable = why_not_playable}; }

std::string why_not_playable(const FaultConfig& fault, const DeviceConfig& device) {
  if (!fault.tracker.empty()) return resolve(fault, device.trackers).error;
  return resolve(fault, *device.rig).error;
}

}  // namespace godobject
