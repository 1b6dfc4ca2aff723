// Laws by which frameworks display a wall at q = 0 on one axis, from the sampled coordinate to the force on
// the device. All but the proxy have a virtual tool of 0.1 kg.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/sampled_wall.h"

namespace godobject {

using WallLaw = std::function<std::function<double(double)>(const SampledWall&)>;

inline constexpr double tool_mass = 0.1;  // kg

/// Returns the law of a proxy that stays on the wall, to which a spring pulls the device (Zilles and
/// Salisbury 1995).
inline std::function<double(double)> proxy_law(const SampledWall& wall) {
  return [K = wall.stiffness](double q) { return K * (std::min(q, 0.0) - q); };
}

/// Returns the law of a coupling by positions (Macklin, Mueller, Chentanez 2016). The tool moves by its
/// velocity; then its coupling of compliance 1 / K and the wall are projected in turn, ten times.
inline std::function<double(double)> position_based_law(const SampledWall& wall) {
  return [K = wall.stiffness, h = wall.period_s, x = wall.q_start, v = 0.0](double q) mutable {
    const double before = x, alpha = 1 / (K * h * h);
    double impulse = 0;  // multiplier of the coupling x - q = 0
    x += h * v;
    for (int k = 0; k < 10; ++k) {
      const double change = (-(x - q) - alpha * impulse) / (1 / tool_mass + alpha);
      impulse += change;
      x = std::min(x + change / tool_mass, 0.0);
    }
    v = (x - before) / h;
    return -impulse / (h * h);  // the tool bears the impulse, the device its opposite
  };
}

/// Returns the law of a tool that a damped constraint welds to the device, with damping 2 sqrt(K m),
/// implicit in stiffness and damping. The force is that of the constraint. The wall is rigid.
inline std::function<double(double)> weld_law(const SampledWall& wall) {
  return [K = wall.stiffness, h = wall.period_s, x = wall.q_start, v = 0.0,
          last = wall.q_start](double q) mutable {
    const double g = 2 * std::sqrt(K * tool_mass), v_q = (q - std::exchange(last, q)) / h;
    v = (tool_mass * v + h * (K * (q - x) + g * v_q)) / (tool_mass + h * (g + h * K));
    if (x + h * v > 0) v = -x / h;
    const double force = K * (q - x - h * v) + g * (v_q - v);
    x += h * v;
    return -force;
  };
}

/// Returns the paper's law: the tool on a damped spring, k = 2 K, g = 1.4 sqrt(k m), in a wall of 20 k. (8)
/// displays K and a share of g / 2.
template <int damper_percent>
std::function<double(double)> god_object_law(const SampledWall& wall) {
  return [K = wall.stiffness, h = wall.period_s, x = wall.q_start, v = 0.0,
          last = wall.q_start](double q) mutable {
    const double k = 2 * K, g = 1.4 * std::sqrt(k * tool_mass), k_wall = 20 * k;
    const double v_q = (q - std::exchange(last, q)) / h;
    const auto solve = [&](double k_w) {
      return (tool_mass * v + h * (k * (q - x) + g * v_q - k_w * x)) / (tool_mass + h * (g + h * (k + k_w)));
    };
    const double free = solve(0);
    v = x + h * free > 0 ? solve(k_wall) : free;
    x += h * v;
    return K * (x - q) + 0.01 * damper_percent * 0.5 * g * (v - v_q);
  };
}

/// Returns the laws with their names.
inline std::vector<std::pair<std::string, WallLaw>> wall_laws() {
  return {{"proxy and spring", proxy_law},
          {"positions", position_based_law},
          {"weld", weld_law},
          {"god-object, spring alone", god_object_law<0>},
          {"god-object, spring and damper", god_object_law<100>}};
}

}  // namespace godobject
