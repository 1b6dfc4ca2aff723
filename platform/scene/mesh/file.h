// Triangle meshes from STL, OBJ and PLY files.
#pragma once

#include <string>

#include "platform/scene/contact/config.h"

namespace godobject {

/// All triangles in the file, polygons cut into triangles; corners at the same place are one vertex.
/// scale: m per unit of the file. Empty, or why it cannot be read and what to do. Whatever the file holds, it takes
/// bounded memory and time that is linear in its size.
std::string read_mesh(const std::string& path, double scale, MeshData& mesh);
/// As read_mesh for the bytes of a file; path says of which format, and is what messages call it.
std::string parse_mesh(std::string_view file, const std::string& path, double scale, MeshData& mesh);

}  // namespace godobject
