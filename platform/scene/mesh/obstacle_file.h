// Data of an obstacle's file: triangles, heights, or centres of spheres.
#pragma once

#include <string>

#include "platform/scene/contact/config.h"

namespace godobject {

/// Reads the file by obstacle.shape.kind. Returns why this failed, with the remedy; empty on success.
std::string load_file(const std::string& path, ObstacleConfig& obstacle);

/// Reads rows of comma-separated heights, m, without a header; the first row is at y = 0.
std::string read_heights(const std::string& path, HeightGrid& grid);

/// Reads a CSV with columns x, y, z, m.
std::string read_centres(const std::string& path, std::vector<Vec3>& centres);

}  // namespace godobject
