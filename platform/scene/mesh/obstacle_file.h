// What a file adds to an obstacle: triangles, heights, or centres of spheres.
#pragma once

#include <string>

#include "platform/scene/contact/config.h"

namespace godobject {

/// Reads the file as what obstacle.shape.kind takes from one. Empty, or why not and what to do.
std::string load_file(const std::string& path, ObstacleConfig& obstacle);

/// Rows of comma-separated heights, m, without a header; the first row is at y = 0.
std::string read_heights(const std::string& path, HeightGrid& grid);

/// CSV with columns x, y, z, m.
std::string read_centres(const std::string& path, std::vector<Vec3>& centres);

}  // namespace godobject
