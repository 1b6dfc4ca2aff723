#include "platform/view/nets.h"

namespace godobject {

std::vector<Vec3> nodes_of(const SceneNets& nets, const ViewSample& sample) {
  if (sample.net_nodes.size() == nets.nodes.size()) return sample.net_nodes;
  std::vector<Vec3> nodes;
  for (const NetNode& node : nets.nodes) {
    const Pose X_WB = node.body == world ? Pose{} : sample.record.bodies[node.body].X_WB;
    nodes.push_back(X_WB.p + X_WB.q * node.p_B);
  }
  return nodes;
}

std::vector<TriangleIndices> triangles_of(const NetRange& net) {
  std::vector<TriangleIndices> triangles = net.triangles;
  const auto first = static_cast<std::uint32_t>(net.first_node);
  for (TriangleIndices& t : triangles)
    for (std::uint32_t& corner : t) corner -= first;
  return triangles;
}

}  // namespace godobject
