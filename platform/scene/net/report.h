// What a net asks of a step, and how quick and slow it is: for `check`.
#pragma once

#include "platform/scene/net/params.h"

namespace godobject {

/// Time constants of a net about its rest, s.
///
/// Fastest: 1 / omega, omega^2 <= max_i (2 sum_j k_ij + k_i) / m_i by Gershgorin's theorem on M^-1 K.
/// Slowest: of nodes on their anchors alone, m x'' + g x' + k x = 0, which springs can only quicken: 1 / Re of the slower
/// root; m / g of those without anchors.
struct NetTimes {
  double fastest = 0, slowest = 0;
};

NetTimes time_constants(const SceneNets& nets);

/// Floating-point operations of an iteration of conjugate gradients: of a spring 23 in the product and 17 each way through
/// the incomplete factor; of a node 75, with what the iteration does to vectors.
inline double flops_of_an_iteration(const SceneNets& nets) {
  return 57.0 * static_cast<double>(nets.springs.size()) + 75.0 * static_cast<double>(nets.nodes.size());
}

}  // namespace godobject
