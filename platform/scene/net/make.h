// Surface of a net from its description in a scene file.
#pragma once

#include <string>

#include "platform/scene/net/config.h"

namespace godobject {

/// Fills net.surface. Returns an error with its remedy; empty on success.
/// path: path of the mesh.
/// room: largest number of vertices.
std::string make_surface(const std::string& path, std::size_t room, NetConfig& net);

}  // namespace godobject
