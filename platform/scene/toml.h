// Scene files: TOML, strict. Format: docs/scenes.md, made from platform/scene/keys/scene.h.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "platform/scene/fault_checks.h"

namespace godobject {

struct LoadResult {
  std::optional<SceneConfig> scene;   // absent where there are errors
  std::vector<std::string> errors;    // all of the file's, each "file:line:column: what; what to do"
  std::vector<std::string> warnings;  // the same form
};

/// checks: of what simulates the scene's device; by default nothing does, and its [[fault]] tables are only read.
LoadResult load_scene(const std::string& path, const FaultChecks& checks = {});
/// As load_scene for a text; file is what messages call it.
LoadResult parse_scene(std::string_view toml, const std::string& file, const FaultChecks& checks = {});

/// Every value that is in effect, defaults included; loads back as the same configuration.
std::string effective_config_toml(const SceneConfig& scene);

/// The key tables of docs/scenes.md, in Markdown.
std::string scene_reference_markdown();

}  // namespace godobject
