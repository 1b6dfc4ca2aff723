#include "tests/study/peer/bag.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "platform/scene/toml.h"

namespace godobject::study {

std::array<double, 2> Bag::bar_at(double t) {
  const double omega = std::numbers::pi / press_time, phase = omega * std::min(t, press_time);
  return {bar_start - bar_press / 2 * (1 - std::cos(phase)), -bar_press / 2 * omega * std::sin(phase)};
}

double Bag::depth(const Vec3& p) const {
  const Vec3 on(bar_at(duration)[0], std::clamp(p.y(), -bar_half, bar_half), 0);
  return bar_radius + node_radius() - (p - on).norm();
}

Bag endobag() {
  LoadResult loaded = load_scene(GODOBJECT_SCENE_DIRECTORY "/endobag.toml");
  if (!loaded.scene) throw std::runtime_error(loaded.errors.front());
  Bag bag{.net = scene_nets(*loaded.scene)};
  for (NetNode& node : bag.net.nodes) {
    node.body = world;
    node.material = 0;
  }
  return bag;
}

}  // namespace godobject::study
