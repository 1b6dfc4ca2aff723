// The half of the library that stands in for simulated devices in a build without them (GODOBJECT_SIM=OFF).
#include "platform/scene/fault_checks.h"
#include "platform/session/make_session.h"

namespace godobject {

Session::Made make_session(const SceneConfig& scene, Motion motion, BusChoice bus, const RigProfiles&) {
  if (bus == BusChoice::direct || driven_bodies(scene).empty())
    return Session::make(scene, std::move(motion));
  return {
      .session = nullptr,
      .errors = {
          "this build has no simulated devices (GODOBJECT_SIM=OFF): give --bus an address, or --bus direct"}};
}

std::unique_ptr<TrackerLink> make_resting_tracker(const TrackerParams& params,
                                                  std::vector<std::string>& errors) {
  errors.push_back("tracker '" + params.name +
                   "': this build has no simulated trackers to check it with (GODOBJECT_SIM=OFF)");
  return nullptr;
}

std::vector<std::string> fault_verb_names() { return {}; }

std::string why_not_playable(const FaultConfig&, const DeviceConfig&) { return ""; }

}  // namespace godobject
