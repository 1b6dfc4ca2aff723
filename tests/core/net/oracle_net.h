// Nets in the oracle, which shares no code with core: nodes are balls, anchors and attachments are springs
// without rest length.
#pragma once

#include "tests/core/net/net_scene.h"
#include "tests/oracle/case/case.h"

namespace godobject {

/// Adds the nets of a scene to a case that has its bodies, in their order. If nodes are held in the world,
/// `ground` is a fixed body after these. Balls are in the order of the nodes.
template <class S>
void add_net(const Running<S>& run, oracle::Case& c, std::size_t ground = world) {
  const auto& net = run.par.net;
  const std::size_t first = c.bodies.size();
  const auto hang = [&](std::size_t body, std::size_t n, const Vec3& p_B, Real k, Real g) {
    c.springs.push_back(
        {.a = body == world ? ground : body, .b = first + n, .p_A = p_B, .k = k, .g = g, .is_anchor = true});
  };
  for (std::size_t n = 0; n < net.num_nodes; ++n) {
    const NetNode& node = net.nodes[n];
    oracle::Body& ball = c.bodies.emplace_back();
    ball.name = std::to_string(n);
    ball.m = node.m;
    ball.I_B = 1e-5 * Mat3::Identity();
    ball.start.p = run.x.net.nodes[n].p_W;
    if (node.k > 0 || node.g > 0) hang(node.body, n, node.p_B, node.k, node.g);
  }
  for (const NetAttachment& one : net.attachments) hang(one.body, one.node, one.p_B, one.k, one.g);
  for (std::size_t s = 0; s < net.num_springs; ++s) {
    const NetSpring& spring = net.springs[s];
    c.springs.push_back(
        {.a = first + spring.i, .b = first + spring.j, .k = spring.k, .g = spring.g, .l_0 = spring.l_0});
  }
}

}  // namespace godobject
