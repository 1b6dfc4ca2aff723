#include "tests/study/peer/bag.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "platform/scene/toml.h"
#include "tests/study/peer/scene_file.h"

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

nlohmann::json bag_json(const Bag& bag, const std::vector<Vec3>& rest) {
  nlohmann::json result{{"h", Bag::h},
                        {"duration", Bag::duration},
                        {"radius", bag.node_radius()},
                        {"bar",
                         {{"radius", Bag::bar_radius},
                          {"half_length", Bag::bar_half},
                          {"start", Bag::bar_start},
                          {"press", Bag::bar_press},
                          {"time", Bag::press_time}}}};
  result["nodes"] = result["springs"] = result["rest"] = nlohmann::json::array();
  for (const NetNode& n : bag.net.nodes)
    result["nodes"].push_back({{"m", n.m}, {"p", list_of(n.p_B)}, {"k", n.k}, {"g", n.g}});
  for (const NetSpring& s : bag.net.springs)
    result["springs"].push_back({{"i", s.i}, {"j", s.j}, {"k", s.k}, {"g", s.g}, {"l", s.l_0}});
  for (const Vec3& p : rest) result["rest"].push_back(list_of(p));
  return result;
}

}  // namespace godobject::study
