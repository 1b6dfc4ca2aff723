// Scene files for the engines of tests/bench/wasm: bodies, joints, shapes, targets and reference poses, JSON.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/oracle/solve.h"
#include "tests/study/contact/scene.h"
#include "tests/study/reference_scene.h"

namespace godobject::study {

/// Returns the elements as a JSON list.
nlohmann::json list_of(const oracle::Vector3d& a);

/// Writes a scene with its reference. Throws std::runtime_error if the file cannot be written.
void write_scene(const std::filesystem::path& file, const ReferenceScene& scene,
                 const oracle::Solution& reference);

/// Writes a scene with contacts, without a reference. Throws as above.
void write_scene(const std::filesystem::path& file, const bench::ContactScene& scene);

}  // namespace godobject::study
