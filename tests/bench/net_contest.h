// The hanging net: 1024 nodes of squares, held at one edge. A ball is pressed into them from the side,
// withdrawn, and kept away until the net rests. The stretch of its springs at rest is known from the weight
// below each.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

#include "core/math/types.h"

namespace godobject::bench {

struct HangingNet {
  static constexpr std::uint32_t across = 32, down = 32, num_nodes = across * down;
  static constexpr double spacing = 5e-3, m = 2.4e-5, k = 200, gravity = 9.81;  // m, kg, N/m, m/s^2
  static constexpr double settling_time = 0.25;                      // s: as for a net in scene files
  static constexpr double g_air = 8 * m / settling_time;             // N s/m, of a node
  static constexpr double node_radius = 1.5e-3, ball_radius = 0.04;  // m
  static constexpr double mu = 0.3, h = 1e-3, period = 1.5;          // s
  static constexpr std::size_t first_pressed = 250, num_pressed = 1000, num_steps = 3000;

  static double g() { return 0.2 * std::sqrt(k * m); }  // N s/m, of a spring
  static bool is_held(std::uint32_t n) { return n < across; }
  static std::uint32_t row(std::uint32_t n) { return n / across; }
  static Vec3 node(std::uint32_t n) {
    return spacing * Vec3(n % across - 0.5 * (across - 1), 0, -static_cast<double>(row(n)));
  }
  static std::vector<std::array<std::uint32_t, 2>> springs() {
    std::vector<std::array<std::uint32_t, 2>> all;
    for (std::uint32_t n = 0; n < num_nodes; ++n) {
      if (n % across + 1 < across) all.push_back({n, n + 1});
      if (n + across < num_nodes) all.push_back({n, n + across});
    }
    return all;
  }
  /// The ball's centre at a time, and its velocity.
  static std::array<Vec3, 2> ball(double t) {
    constexpr double gap = 2e-3, amplitude = 0.03, omega = 2 * std::numbers::pi / period;
    const double u = std::min(t, period);
    return {Vec3(0, -ball_radius - node_radius - gap + amplitude * (1 - std::cos(omega * u)),
                 -0.6 * spacing * down),
            Vec3(0, amplitude * omega * std::sin(omega * u), 0)};
  }
};

/// Returns the largest difference of a hanging spring's strain from that at rest.
template <class NodeAt>
double stretch_error(NodeAt at) {
  using Net = HangingNet;
  double worst = 0;
  for (std::uint32_t n = 0; n + Net::across < Net::num_nodes; ++n) {
    const double below = Net::down - 1 - Net::row(n);
    const double strain = below * Net::m * Net::gravity / (Net::k * Net::spacing);
    const double length = (at(n + Net::across) - at(n)).norm();
    worst = std::max(worst, std::abs(length / Net::spacing - 1 - strain));
  }
  return worst;
}

/// The hanging net in another engine.
class NetPeer {
 public:
  virtual ~NetPeer() = default;
  virtual void restart() = 0;
  /// From tick n to n + 1.
  virtual void step(std::size_t n) = 0;
  virtual Vec3 node(std::uint32_t n) const = 0;
  virtual std::size_t num_contacts() const = 0;
};

}  // namespace godobject::bench
