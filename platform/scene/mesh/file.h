// Triangle meshes from STL, OBJ and PLY files.
#pragma once

#include <string>

#include "platform/scene/contact/config.h"

namespace godobject {

/// Reads all triangles of the file, polygons cut into triangles and equal corners merged. Returns why it
/// cannot be read, with the remedy; empty on success. Memory is bounded and time linear in the size of any
/// file.
/// scale: m per unit of the file.
std::string read_mesh(const std::string& path, double scale, MeshData& mesh);
/// Parses the bytes of a file as read_mesh() does.
/// path: selects the format, and is the name in messages.
std::string parse_mesh(std::string_view file, const std::string& path, double scale, MeshData& mesh);

}  // namespace godobject
