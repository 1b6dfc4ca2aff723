#include "platform/cli/run_trackers.h"

#include <algorithm>

#include "platform/cli/named_address.h"

namespace godobject {
namespace {

void plan_port(const std::string& text, std::vector<TrackerParams>& trackers, std::vector<bool>& has_port,
               std::vector<std::string>& errors) {
  const NamedAddress given = split_name(text, '/');  // a port is a path
  const auto tracker = given.name.empty() && trackers.size() == 1
                           ? trackers.begin()
                           : std::ranges::find(trackers, given.name, &TrackerParams::name);
  if (tracker == trackers.end()) {
    errors.push_back("--tracker " + text + ": the scene's trackers are " + quoted_names(trackers) +
                     ": give " + trackers.front().name + "=PORT");
    return;
  }
  const auto index = static_cast<std::size_t>(tracker - trackers.begin());
  if (has_port[index]) errors.push_back("--tracker: tracker '" + tracker->name + "' is given twice");
  if (given.address.empty()) errors.push_back("--tracker " + text + ": the port is missing");
  has_port[index] = true;
  tracker->port = given.address;
}

}  // namespace

void plan_trackers(std::span<const std::string> given, bool buses_are_given, SceneConfig& scene,
                   BusPlan& plan, std::vector<std::string>& errors) {
  if (given.empty()) return;
  if (!scene.device || scene.device->trackers.empty()) {
    errors.push_back("--tracker: scene '" + scene.name + "' has no trackers");
    return;
  }
  if (plan.choice != BusChoice::real && (scene.device->rig || buses_are_given)) {
    errors.push_back(
        "--tracker: real trackers keep real time, and the buses of this run do not: give --bus the addresses "
        "of "
        "real ones, or leave --tracker out");
    return;
  }
  plan.choice = BusChoice::real;
  std::vector<TrackerParams>& trackers = scene.device->trackers;
  std::vector<bool> has_port(trackers.size(), false);
  for (const std::string& text : given) {
    if (text == "scene") has_port.assign(trackers.size(), true);
    else plan_port(text, trackers, has_port, errors);
  }
  for (std::size_t i = 0; i < trackers.size(); ++i)
    if (!has_port[i] && errors.empty())
      errors.push_back("--tracker: tracker '" + trackers[i].name +
                       "' of the scene has no port: give --tracker " + trackers[i].name + "=PORT");
}

}  // namespace godobject
