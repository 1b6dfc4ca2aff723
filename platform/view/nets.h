// Nets for the view.
#pragma once

#include <vector>

#include "platform/scene/net/params.h"
#include "platform/view/tap.h"

namespace godobject {

/// Returns the positions of the nodes, world, m: those of the sample, or the nodes' anchors if the sample has
/// none, as with traces.
std::vector<Vec3> nodes_of(const SceneNets& nets, const ViewSample& sample);

/// Returns the positions of the nodes at the start, world, m.
std::vector<Vec3> nodes_at_start(const SceneConfig& scene);

/// Returns the triangles of a net, with the net's own node indices.
std::vector<TriangleIndices> triangles_of(const NetRange& net);

}  // namespace godobject
