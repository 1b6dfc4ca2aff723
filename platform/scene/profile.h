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
  std::optional<NodeProfile> profile;  // absent where there are errors
  std::vector<std::string> errors;     // all of the file's, each "file:line:column: what; what to do"
};

/// file: what messages call it.
ProfileResult parse_profile(std::string_view toml, const std::string& file);
ProfileResult load_profile(const std::string& path);

/// The keys as Markdown tables, for docs/canopen.md.
std::string profile_reference_markdown();

struct RigProfilesResult {
  RigProfiles profiles;
  std::vector<std::string> errors;  // empty: the profiles are there and fit the rig
};

/// The profiles that the rig's encoders and drives name: a path (with a '/' or ending in ".toml", from
/// scene_folder), or a name, looked for as NAME.toml in scene_folder and then among those shipped.
/// scene_file: in messages, with the line that names a profile; empty: not in them.
RigProfilesResult load_profiles(const RigParams& rig, const std::string& scene_folder,
                                const std::string& scene_file = "");

/// Names of the shipped profiles.
std::vector<std::string> shipped_profiles();

}  // namespace godobject
