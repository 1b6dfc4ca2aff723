// What a net asks of a step, and how quick and slow it is: for `check`.
#pragma once

#include <optional>

#include "platform/scene/net/params.h"

namespace godobject {

/// Time constants of small motions of nets about their rest, their carriers and what they are attached to held, s. Both are
/// bounds. k_i and g_i are those of a node's anchor and attachments together.
///
/// Fastest: 1 / omega, omega^2 <= max_i (2 sum_j k_ij + k_i) / m_i by Gershgorin's theorem on M^-1 K.
///
/// Slowest: an eigenvector of M x'' + G x' + K x = 0 has the polynomial p(s) = m s^2 - g s + k of its decay s, whose numbers are
/// sums over nodes on their anchors, p_i(s) = m_i s^2 - g_i s + k_i, and over springs, k_s - g_s s, each times a square. Where it
/// swings, s = g / 2m >= min_i g_i / 2 m_i. Where it creeps, p(s) = 0; but below the slower roots of all p_i that have any and
/// below k_s / g_s of all springs no summand is negative, and some p_i(s) > 0. So
///
///   1 / s <= max(of the node that is slowest on its anchor alone, of the spring with the longest g_s / k_s)
///
/// None where an anchor has no spring or no damper: how slowly such a node is taken along depends on all of the net.
struct NetTimes {
  double fastest = 0;
  std::optional<double> slowest;
};

NetTimes time_constants(const SceneNets& nets);

/// Floating-point operations of an iteration of conjugate gradients: of a spring 24 in the product and 18 each way through
/// the incomplete factor; of a node 75, with what the iteration does to vectors.
inline double flops_of_an_iteration(const SceneNets& nets) {
  return 60.0 * static_cast<double>(nets.springs.size()) + 75.0 * static_cast<double>(nets.nodes.size());
}

}  // namespace godobject
