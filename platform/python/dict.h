// Scenes from dicts of Python: their TOML tables, their TOML text, and the key of each of its lines.
#pragma once

#include <pybind11/pybind11.h>

#include <optional>
#include <string>

#include <toml++/toml.h>

namespace godobject {

/// Returns the tables of the scene; none if a value is not of a scene or is rare, which the text reports.
/// plain: as in toml_of_dict().
std::optional<toml::table> table_of_dict(const pybind11::dict& scene, const pybind11::function& plain);

/// Returns the TOML text of the scene. Raises SceneError with the key of a value that scenes do not have.
/// file: name of the scene in errors.
/// plain: Python function that converts other types, such as arrays, to those of Python itself.
std::string toml_of_dict(const pybind11::dict& scene, const std::string& file,
                         const pybind11::function& plain);

/// Returns the key of each line of that text, such as "body[0].mass".
pybind11::list keys_of_dict(const pybind11::dict& scene, const std::string& file,
                            const pybind11::function& plain);

}  // namespace godobject
