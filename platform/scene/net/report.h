// Cost of a net per step, and its time constants, for `check`.
#pragma once

#include <optional>

#include "platform/scene/net/params.h"

namespace godobject {

/// Bounds of the time constants of small motions of nets about their rest, s, with carriers and attached
/// bodies held. k_i and g_i are those of a node's anchor and attachments together.
///
/// Fastest: 1 / omega, omega^2 <= max_i (2 sum_j k_ij + k_i) / m_i by Gershgorin's theorem on M^-1 K.
///
/// Slowest: an eigenvector of M x'' + G x' + K x = 0 has the polynomial p(s) = m s^2 - g s + k of its decay
/// rate s. p is a sum of terms, each times a square: p_i(s) = m_i s^2 - g_i s + k_i of each node on its
/// anchor, and k_s - g_s s of each spring. An oscillating mode has s = g / 2m >= min_i g_i / 2 m_i. A
/// creeping mode has p(s) = 0. Below the slower real roots of all p_i and below k_s / g_s of all springs no
/// term is negative, and some p_i(s) > 0. So
///
///   1 / s <= max(time constant of the slowest node on its anchor alone, largest g_s / k_s of all springs)
///
/// None if an anchor has no spring or no damper, because the motion of such a node depends on the whole net.
struct NetTimes {
  double fastest = 0;
  std::optional<double> slowest;
};

NetTimes time_constants(const SceneNets& nets);

/// Returns the floating-point operations of an iteration of conjugate gradients. A spring takes 24 in the
/// product and 18 in each pass through the incomplete factor; a node takes 75, vector operations included.
inline double flops_of_an_iteration(const SceneNets& nets) {
  return 60.0 * static_cast<double>(nets.springs.size()) + 75.0 * static_cast<double>(nets.nodes.size());
}

}  // namespace godobject
