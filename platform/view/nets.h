// Nets as a view shows them.
#pragma once

#include <vector>

#include "platform/scene/net/params.h"
#include "platform/view/tap.h"

namespace godobject {

/// Where the nodes are, in the world, m: as the sample says; on their anchors where it says nothing of them, as a trace does.
std::vector<Vec3> nodes_of(const SceneNets& nets, const ViewSample& sample);

/// Where the nodes are at the start, in the world, m.
std::vector<Vec3> nodes_at_start(const SceneConfig& scene);

/// The triangles of a net, by numbers of its own nodes.
std::vector<TriangleIndices> triangles_of(const NetRange& net);

}  // namespace godobject
