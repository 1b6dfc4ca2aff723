// Scenes from TOML tables that a program has built, without their text.
#pragma once

#include <string>

#include <toml++/toml.h>

#include "platform/scene/toml.h"

namespace godobject {

/// Reads a scene as parse_scene() does. Errors and warnings have no places if the table was not parsed.
LoadResult read_scene(const toml::table& table, const std::string& file, const FaultChecks& checks = {});

}  // namespace godobject
