#include "platform/cli/run/buses.h"

#include <algorithm>

namespace godobject {

BusPlan plan_buses(std::span<const std::string> given, const SceneConfig& scene,
                   std::vector<std::string>& errors, std::vector<std::string>& notes) {
  BusPlan plan;
  const auto is_choice = [](const std::string& text) { return text == "sim" || text == "direct"; };
  if (given.empty()) {
    if (scene.device && (scene.device->rig || !scene.device->trackers.empty())) return plan;
    const bool has_other_hand = scene.device && scene.device->spacemouse;
    if (!has_other_hand)
      notes.push_back("scene '" + scene.name + "' describes no buses: this run uses --bus direct");
    plan.choice = BusChoice::direct;
  } else if (std::ranges::any_of(given, is_choice)) {
    if (given.size() > 1) errors.push_back("--bus: sim and direct apply to all buses: give --bus once");
    plan.choice = given.front() == "sim" ? BusChoice::sim : BusChoice::direct;
  } else {
    plan.choice = BusChoice::real;
    if (scene.device && scene.device->rig) plan.real = rig_addresses(given, scene, "--bus", errors);
    else
      errors.push_back("--bus: scene '" + scene.name +
                       "' describes no buses: add them, with encoders and joints, or use --bus direct");
  }
  return plan;
}

}  // namespace godobject
