// Device profiles: TOML, strict, as scene files are. Format: docs/canopen.md.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "hal/rig/params.h"

namespace godobject {

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
