// A file of [[fault]] tables, as scenes have them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "platform/scene/fault_checks.h"

namespace godobject {

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

}  // namespace godobject
