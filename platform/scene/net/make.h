// The surface of a net as its scene file describes it.
#pragma once

#include <string>

#include "platform/scene/net/config.h"

namespace godobject {

/// Fills in net.surface; path: of the mesh. room: vertices that it may have. Empty, or what is wrong and what to do.
std::string make_surface(const std::string& path, std::size_t room, NetConfig& net);

}  // namespace godobject
