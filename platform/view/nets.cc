#include "platform/view/nets.h"

namespace godobject {

namespace {

/// Returns the anchors of the nodes. X_WB(body): pose of that body.
template <class Where>
std::vector<Vec3> on_anchors(const SceneNets& nets, const Where& X_WB) {
  std::vector<Vec3> nodes;
  for (const NetNode& node : nets.nodes) {
    const Pose X = node.body == world ? Pose{} : X_WB(node.body);
    nodes.push_back(X.p + X.q * node.p_B);
  }
  return nodes;
}

}  // namespace

std::vector<Vec3> nodes_of(const SceneNets& nets, const ViewSample& sample) {
  if (sample.net_nodes.size() == nets.nodes.size()) return sample.net_nodes;
  return on_anchors(nets, [&](std::size_t body) { return sample.record.bodies[body].X_WB; });
}

std::vector<Vec3> nodes_at_start(const SceneConfig& scene) {
  return on_anchors(scene_nets(scene), [&](std::size_t body) { return scene.bodies[body].X_WB; });
}

std::vector<TriangleIndices> triangles_of(const NetRange& net) {
  std::vector<TriangleIndices> triangles = net.triangles;
  const auto first = static_cast<std::uint32_t>(net.first_node);
  for (TriangleIndices& t : triangles)
    for (std::uint32_t& corner : t) corner -= first;
  return triangles;
}

}  // namespace godobject
