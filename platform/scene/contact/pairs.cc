#include "platform/scene/contact/params.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "platform/scene/net/params.h"

namespace godobject {
namespace {

bool is_touchable(const BodyConfig& body) { return !body.spheres.empty() || !body.shapes.empty(); }

MaterialUse use_of(const SphereConfig& sphere, const BodyConfig& body) {
  return {sphere.material, "sphere of body '" + body.name + "'"};
}
MaterialUse use_of(const ShapeConfig& shape, const BodyConfig& body) {
  return {shape.material, "shape of body '" + body.name + "'"};
}

/// Returns each material with its first use.
template <class Part>
std::vector<MaterialUse> uses_of(const std::vector<Part>& parts, const BodyConfig& body) {
  std::set<std::string_view> known;
  std::vector<MaterialUse> uses;
  for (const Part& part : parts)
    if (known.insert(part.material).second) uses.push_back(use_of(part, body));
  return uses;
}

std::vector<MaterialUse> sphere_uses(const BodyConfig& body) { return uses_of(body.spheres, body); }

std::vector<MaterialUse> shape_uses(const BodyConfig& body) { return uses_of(body.shapes, body); }

/// Returns the materials of the body that spheres of others touch.
std::vector<MaterialUse> surface_uses(const BodyConfig& body) {
  if (body.shapes.empty()) return sphere_uses(body);
  return uses_of(body.shapes, body);
}

/// only_points: true for the obstacles that have points, which touch shapes.
std::vector<MaterialUse> obstacle_uses(const SceneConfig& scene, bool only_points = false) {
  std::vector<MaterialUse> uses;
  for (const ObstacleConfig& obstacle : scene.obstacles)
    if (!only_points || num_points(obstacle.shape.kind) > 0)
      uses.push_back({obstacle.shape.material, "obstacle '" + obstacle.name + "'"});
  return uses;
}

/// Returns the material of the net's nodes; empty if they have no contacts.
std::vector<MaterialUse> node_uses(const NetConfig& net) {
  if (net.thickness.value_or(0) == 0) return {};
  return {{net.material, "net '" + net.name + "'"}};
}

/// True if the shape has points that no sphere of the body rounds.
bool has_points(const BodyConfig& body, const ShapeConfig& config) {
  const ShapeParams shape = shape_params(config);
  for (std::uint32_t j = 0; j < num_points(shape.kind); ++j) {
    bool is_rounded = false;
    for (const SphereConfig& row : body.spheres)
      for (int i = 0; i < row.count; ++i)
        is_rounded = is_rounded || rounds(to_body(shape.X_WS.q, row.p_B + i * row.spacing - shape.X_WS.p),
                                          row.radius, shape, j);
    if (!is_rounded) return true;
  }
  return false;
}

/// Set of unordered pairs, each stored once.
class PairList {
 public:
  void add(const std::vector<MaterialUse>& as, const std::vector<MaterialUse>& bs) {
    for (const MaterialUse& a : as)
      for (const MaterialUse& b : bs)
        if (known_.insert(std::minmax(a.material, b.material)).second) pairs_.push_back({a, b});
  }
  std::vector<MaterialPair> take() { return std::move(pairs_); }

 private:
  std::set<std::pair<std::string, std::string>> known_;
  std::vector<MaterialPair> pairs_;
};

/// True if the net's nodes touch the body, which must not belong to the carrier's tool.
bool meets(const SceneConfig& scene, const std::vector<std::size_t>& tool, const NetConfig& net,
           std::size_t body) {
  const std::optional<std::size_t> carrier = body_named(scene, net.body);
  return !node_uses(net).empty() && (!carrier || tool[*carrier] != tool[body]);
}

}  // namespace

std::vector<std::size_t> tools_of(const SceneConfig& scene) {
  std::vector<std::size_t> tool(scene.bodies.size());
  std::iota(tool.begin(), tool.end(), std::size_t{0});
  for (const auto* joints : {&scene.joints, &scene.loops}) {
    for (const JointConfig& joint : *joints) {
      const std::optional<std::size_t> parent = body_named(scene, joint.parent),
                                       child = body_named(scene, joint.child);
      if (!parent || !child) continue;
      const auto [first, second] = std::minmax(tool[*parent], tool[*child]);
      std::ranges::replace(tool, std::size_t{second}, std::size_t{first});
    }
  }
  return tool;
}

ContactScope contact_scope(const SceneConfig& scene) {
  const auto touches = [](const NetConfig& net) { return !node_uses(net).empty(); };
  if (std::ranges::none_of(scene.bodies, is_touchable) && std::ranges::none_of(scene.nets, touches))
    return ContactScope::none;
  const std::vector<std::size_t> tool = tools_of(scene);
  for (const NetConfig& net : scene.nets)
    for (std::size_t i = 0; i < scene.bodies.size(); ++i)
      if (meets(scene, tool, net, i) && is_touchable(scene.bodies[i])) return ContactScope::bodies;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    for (std::size_t j = 0; j < scene.bodies.size(); ++j)
      if (tool[i] != tool[j] && is_touchable(scene.bodies[i]) && is_touchable(scene.bodies[j]))
        return ContactScope::bodies;
  if (std::ranges::count_if(scene.nets, touches) > 1) return ContactScope::bodies;
  if (std::ranges::any_of(scene.nets, &NetConfig::touches_itself)) return ContactScope::bodies;
  const bool is_alone = scene.obstacles.empty() && scene.world_planes == 0;
  return is_alone ? ContactScope::none : ContactScope::obstacles;
}

std::vector<MaterialUse> materials_of(const SceneConfig& scene) {
  std::set<std::string> known;
  std::vector<MaterialUse> materials;
  const auto add = [&](const std::vector<MaterialUse>& uses) {
    for (const MaterialUse& use : uses)
      if (known.insert(use.material).second) materials.push_back(use);
  };
  for (const BodyConfig& body : scene.bodies) {
    add(sphere_uses(body));
    add(surface_uses(body));
  }
  for (const NetConfig& net : scene.nets) add(node_uses(net));
  add(obstacle_uses(scene));
  return materials;
}

std::vector<MaterialPair> pairs_that_meet(const SceneConfig& scene) {
  const std::vector<std::size_t> tool = tools_of(scene);
  const std::vector<MaterialUse> obstacles = obstacle_uses(scene),
                                 obstacles_with_points = obstacle_uses(scene, true);
  std::vector<std::vector<MaterialUse>> surfaces;
  for (const BodyConfig& body : scene.bodies) surfaces.push_back(surface_uses(body));
  PairList pairs;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const std::vector<MaterialUse> spheres = sphere_uses(scene.bodies[i]);
    pairs.add(spheres, obstacles);
    for (const ShapeConfig& shape : scene.bodies[i].shapes)
      pairs.add({use_of(shape, scene.bodies[i])},
                has_points(scene.bodies[i], shape) ? obstacles : obstacles_with_points);
    for (std::size_t j = i + 1; j < scene.bodies.size(); ++j)
      if (tool[i] != tool[j]) pairs.add(shape_uses(scene.bodies[i]), shape_uses(scene.bodies[j]));
    for (std::size_t j = 0; j < scene.bodies.size(); ++j)
      if (tool[i] != tool[j]) pairs.add(spheres, surfaces[j]);
  }
  for (const NetConfig& net : scene.nets) {
    pairs.add(node_uses(net), obstacles);
    for (const NetConfig& other : scene.nets)
      if (&other != &net || net.touches_itself) pairs.add(node_uses(net), node_uses(other));
    for (std::size_t i = 0; i < scene.bodies.size(); ++i)
      if (meets(scene, tool, net, i)) pairs.add(node_uses(net), surfaces[i]);
  }
  return pairs.take();
}

const ContactConfig* contact_of(const SceneConfig& scene, const std::string& a, const std::string& b) {
  for (const ContactConfig& contact : scene.contacts) {
    const std::vector<std::string>& m = contact.materials;
    if (m.size() == 2 && ((m[0] == a && m[1] == b) || (m[0] == b && m[1] == a))) return &contact;
  }
  return nullptr;
}

}  // namespace godobject
