// Conversion of a scene's nets into nodes and springs of the core (decision 049), with the surfaces for
// display. Nodes start on their anchors. A_i: a third of the area of a vertex's triangles; A_1, A_2: areas of
// the triangles at an edge.
//
//   m_i = sigma A_i,  k_ij = E t (A_1 + A_2) / l_ij^2,  g_ij = tau k_ij  (equilateral: k_ij = sqrt(3)/2 E t)
//   k_i = kappa A_i,  g_i = 8 sigma A_i / T  of anchors; T: settling time
//   k, tau k  of attachments
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "core/net/setup.h"
#include "platform/scene/scene.h"

namespace godobject {

/// A net as a range of the nodes of all nets.
struct NetRange {
  std::string name;
  std::size_t carrier = world;  // index of the body, or world
  std::size_t first_node = 0, num_nodes = 0;
  std::vector<TriangleIndices> triangles;  // corners: numbers of nodes among all nets
};

/// Nets in the order of their carriers, those of the world last; springs in the order of i, then j;
/// attachments in the order of the nets.
struct SceneNets {
  std::vector<NetNode> nodes;
  std::vector<NetSpring> springs;
  std::vector<NetAttachment> attachments;
  std::vector<NetRange> nets;
  int max_iterations = 0;  // largest number in a stage, for all nets
};

/// Converts the nets of a scene that was read without errors.
SceneNets scene_nets(const SceneConfig& scene);

/// Sets the parameters of a composition that has room for the nets.
template <class Params>
void set_net_params(const SceneNets& nets, Params& par) noexcept {
  par.num_nodes = nets.nodes.size();
  std::ranges::copy(nets.nodes, par.nodes.begin());
  par.num_springs = nets.springs.size();
  std::ranges::copy(nets.springs, par.springs.begin());
  if constexpr (requires { par.attachments.list; }) {
    par.attachments.size = nets.attachments.size();
    std::ranges::copy(nets.attachments, par.attachments.list.begin());
  }
  par.max_iterations = nets.max_iterations;
  put_in_order(par);
}

/// Returns the number of springs of a net with this surface and these settings.
std::size_t num_springs(const NetConfig& net);

/// Returns the number of attached nodes, by one ball or by all of them.
std::size_t num_within(const NetConfig& net, const AttachedConfig& ball);
std::size_t num_attachments(const NetConfig& net);

}  // namespace godobject
