#include "platform/rig/profiles.h"

#include <filesystem>
#include <utility>

#include "hal/rig/profile_validate.h"
#include "hal/rig/watchdog.h"
#include "platform/scene/toml.h"

namespace godobject {

RigProfiles checked_profiles(SceneConfig& scene, const std::string& scene_file,
                             std::vector<std::string>& errors) {
  RigParams& rig = *scene.device->rig;
  RigProfilesResult loaded =
      load_profiles(rig, scene.step, std::filesystem::path(scene_file).parent_path().string(), scene_file);
  errors.insert(errors.end(), loaded.errors.begin(), loaded.errors.end());
  if (loaded.errors.empty() && shows_force(scene.device->kind))
    for (const std::string& line : missing_watchdogs(rig, scene.step, loaded.profiles))
      errors.push_back(scene_file + ": " + line);
  apply_profiles(loaded.profiles, rig);
  return std::move(loaded.profiles);
}

}  // namespace godobject
