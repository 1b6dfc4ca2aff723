// What a net's physical numbers imply, where a scene file does not say: decision 049 has the reasons.
#pragma once

#include <cmath>

#include "platform/scene/net/config.h"
#include "platform/scene/net/edges.h"

namespace godobject {

inline constexpr double default_net_damping_ratio =
    1.4;  // g / sqrt(k m) of anchors and springs: as of couplings (2)

/// Stiffness of a spring in an equilateral lattice of a membrane with this E t in plane stress (Seung, Nelson 1988):
/// k = sqrt(3)/2 E t, N/m.
inline double lattice_stiffness(double membrane_stiffness) { return std::sqrt(3.0) / 2 * membrane_stiffness; }

/// What is left of an oscillation a(t) = a_0 exp(-d t / (2 sigma)) after T is exp(-4), 2 %: d = 8 sigma / T, N s/m^3.
inline double drag(double surface_density, double settling_time) {
  return 8 * surface_density / settling_time;
}

/// kappa where d / sqrt(kappa sigma) is the default ratio, N/m^3.
inline double anchor_stiffness_for(double surface_density, double settling_time) {
  const double d = drag(surface_density, settling_time) / default_net_damping_ratio;
  return d * d / surface_density;
}

/// Stiffness that holds a vertex: ten springs of the lattice, so that what holds gives a tenth of what is held. N/m.
inline double held_stiffness_for(double membrane_stiffness) {
  return 10 * lattice_stiffness(membrane_stiffness);
}

/// Bending springs stiffen the membrane: those of an equilateral lattice by three times their ratio, which structural springs
/// are made softer by.
inline double structural_share(double bending) { return 1 / (1 + 3 * bending); }

/// kg; 0 without vertices.
inline double mean_node_mass(const NetConfig& net) {
  const std::size_t n = net.surface.vertices.size();
  return n == 0 ? 0 : net.surface_density * area_of(net.surface) / static_cast<double>(n);
}

}  // namespace godobject
