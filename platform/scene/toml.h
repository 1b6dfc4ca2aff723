// Files in TOML, read strictly: scenes, faults and device profiles. Formats: docs/scenes.md and
// docs/canopen.md, generated from platform/scene/keys.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "hal/rig/params.h"
#include "platform/scene/scene.h"
#include "platform/scene/text/diagnostics.h"

namespace godobject {

/// Checks of [[fault]] tables by a simulated device (platform/simulated), passed to the readers of scenes.
/// Both null: no simulator is linked, and fault verbs are not checked.
struct FaultChecks {
  /// Returns all verbs that can be played.
  std::vector<std::string> (*verbs)() = nullptr;
  /// Returns why the simulated device cannot play the fault; empty if it can.
  std::string (*why_not_playable)(const FaultConfig& fault, const DeviceConfig& device) = nullptr;
};

struct LoadResult {
  std::optional<SceneConfig> scene;   // absent if there are errors
  std::vector<std::string> errors;    // all errors of the file, each "file:line:column: text; remedy"
  std::vector<std::string> warnings;  // of the same form
  std::vector<PlacedText> placed_errors{}, placed_warnings{};  // with their places
};

/// checks: checks by the simulator of the scene's device. By default there is none, and [[fault]] tables are
/// only read.
LoadResult load_scene(const std::string& path, const FaultChecks& checks = {});
/// Parses a text as load_scene() parses a file.
/// file: name in messages.
LoadResult parse_scene(std::string_view toml, const std::string& file, const FaultChecks& checks = {});

/// Returns every value in effect, with defaults, as a scene file of the same configuration.
std::string effective_config_toml(const SceneConfig& scene);

/// Returns the lists of keys of docs/scenes.md in Markdown.
std::string scene_reference_markdown();

/// A file of [[fault]] tables, as scenes have them.
struct FaultsResult {
  std::vector<FaultConfig> faults;
  std::vector<std::string> errors;  // "file:line:column: text"
};

/// Reads faults for this scene's rig.
FaultsResult load_faults(const std::string& path, const SceneConfig& scene, const FaultChecks& checks = {});
/// Parses a text as load_faults() parses a file.
/// file: name in messages.
FaultsResult parse_faults(std::string_view toml, const std::string& file, const SceneConfig& scene,
                          const FaultChecks& checks = {});

/// A device profile.
struct ProfileResult {
  std::optional<NodeProfile> profile;  // absent if there are errors
  std::vector<std::string> errors;     // all errors of the file, each "file:line:column: text; remedy"
};

/// file: name in messages.
ProfileResult parse_profile(std::string_view toml, const std::string& file);
ProfileResult load_profile(const std::string& path);

/// Returns the keys as Markdown lists for docs/canopen.md.
std::string profile_reference_markdown();

struct RigProfilesResult {
  RigProfiles profiles;
  std::vector<std::string> errors;  // empty: the profiles exist and fit the rig
};

/// Loads the profiles of the rig's encoders and drives. A name with '/' or ending in ".toml" is a path from
/// scene_folder. Any other NAME is NAME.toml in scene_folder or among the shipped ones.
/// cycle_s: SYNC period, s. scene_file: file name in messages, with the line of the profile's name; empty:
/// omitted.
RigProfilesResult load_profiles(const RigParams& rig, double cycle_s, const std::string& scene_folder,
                                const std::string& scene_file = "");

/// Returns the names of the shipped profiles.
std::vector<std::string> shipped_profiles();

}  // namespace godobject
