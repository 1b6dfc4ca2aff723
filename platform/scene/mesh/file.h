// Files of obstacles and nets: triangle meshes from STL, OBJ and PLY, heights, and centres of spheres.
#pragma once

#include <string>

#include "platform/scene/geometry.h"

namespace godobject {

/// Reads all triangles of the file, polygons cut into triangles and equal corners merged. Returns why it
/// cannot be read, with the remedy; empty on success. Memory is bounded and time linear in the size of any
/// file.
/// scale: m per unit of the file.
std::string read_mesh(const std::string& path, double scale, MeshData& mesh);
/// Parses the bytes of a file as read_mesh() does.
/// path: selects the format, and is the name in messages.
std::string parse_mesh(std::string_view file, const std::string& path, double scale, MeshData& mesh);

/// Reads the file of an obstacle by obstacle.shape.kind. Returns why this failed, with the remedy; empty on
/// success.
std::string load_file(const std::string& path, ObstacleConfig& obstacle);

/// Reads rows of comma-separated heights, m, without a header; the first row is at y = 0.
std::string read_heights(const std::string& path, HeightGrid& grid);

/// Reads a CSV with columns x, y, z, m.
std::string read_centres(const std::string& path, std::vector<Vec3>& centres);

}  // namespace godobject
