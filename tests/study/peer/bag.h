// The bag of endobag.toml without its rod: its nodes are on anchors of the world, and a bar is pressed into
// it. Without gravity and friction, so that all engines have the same place of rest.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <vector>

#include "platform/scene/net/params.h"

namespace godobject::study {

struct Bag {
  static constexpr double h = 1e-3, duration = 2;               // s
  static constexpr double bar_radius = 0.012, bar_half = 0.1;   // m; its axis is y
  static constexpr double bar_start = 0.046, bar_press = 0.02;  // m along x: at the start, and moved by
  static constexpr double press_time = 1;                       // s, after which the bar rests
  static constexpr double contact_stiffness = 200;              // N/m, as in the scene
  SceneNets net;

  double node_radius() const { return net.nodes.front().radius; }
  /// Returns the bar's centre on x, and its speed.
  static std::array<double, 2> bar_at(double t);
  /// Returns how deep a node at p is in the bar at the end, m; negative outside.
  double depth(const Vec3& p) const;
};

/// Reads the scene. Throws std::runtime_error.
Bag endobag();
/// Returns the scene for the engines of tests/bench/wasm. rest: of bag_at_rest().
nlohmann::json bag_json(const Bag& bag, const std::vector<Vec3>& rest);

}  // namespace godobject::study
