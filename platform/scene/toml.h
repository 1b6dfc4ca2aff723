// Scene files: TOML, strict. Format: docs/scenes.md, generated from platform/scene/keys/scene.h.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "platform/scene/fault_checks.h"

namespace godobject {

struct LoadResult {
  std::optional<SceneConfig> scene;   // absent if there are errors
  std::vector<std::string> errors;    // all errors of the file, each "file:line:column: text; remedy"
  std::vector<std::string> warnings;  // of the same form
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

}  // namespace godobject
