// Triangle meshes from STL, OBJ and PLY files, by the Open Asset Import Library.
#pragma once

#include <string>

#include "sim/contact_config.h"

namespace godobject {

/// Triangles of all meshes in the file, polygons cut into triangles; corners at the same place are one vertex.
/// scale: m per unit of the file. Empty, or why it cannot be read and what to do.
std::string read_mesh(const std::string& path, double scale, MeshData& mesh);

}  // namespace godobject
