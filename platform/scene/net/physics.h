// Defaults of a net's physical numbers, derived in decision 049.
#pragma once

#include <cmath>

#include "platform/scene/net/config.h"
#include "platform/scene/net/edges.h"

namespace godobject {

inline constexpr double default_net_damping_ratio =
    1.4;  // g / sqrt(k m) of anchors and springs, as of couplings (2)

/// Returns the stiffness k = sqrt(3)/2 E t of a spring, N/m, in an equilateral lattice equal to a membrane of
/// this E t in plane stress (Seung, Nelson 1988).
inline double lattice_stiffness(double membrane_stiffness) { return std::sqrt(3.0) / 2 * membrane_stiffness; }

/// Returns d = 8 sigma / T, N s/m^3, at which an oscillation a(t) = a_0 exp(-d t / (2 sigma)) decays within T
/// to exp(-4), 2 %.
inline double drag(double surface_density, double settling_time) {
  return 8 * surface_density / settling_time;
}

/// Returns kappa at which d / sqrt(kappa sigma) is the default ratio, N/m^3.
inline double anchor_stiffness_for(double surface_density, double settling_time) {
  const double d = drag(surface_density, settling_time) / default_net_damping_ratio;
  return d * d / surface_density;
}

/// Returns the stiffness that holds a node: ten springs of the lattice, so that the holder deforms by a tenth
/// of the net. N/m.
inline double held_stiffness_for(double membrane_stiffness) {
  return 10 * lattice_stiffness(membrane_stiffness);
}

/// Returns the factor of structural springs that compensates the bending springs. These stiffen the membrane
/// of an equilateral lattice by three times their ratio.
inline double structural_share(double bending) { return 1 / (1 + 3 * bending); }

/// Returns the mean mass of a node, kg; 0 without vertices.
inline double mean_node_mass(const NetConfig& net) {
  const std::size_t n = net.surface.vertices.size();
  return n == 0 ? 0 : net.surface_density * area_of(net.surface) / static_cast<double>(n);
}

}  // namespace godobject
