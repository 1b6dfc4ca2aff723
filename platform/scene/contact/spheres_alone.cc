#include "platform/scene/contact/spheres_alone.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "platform/scene/contact/pairs.h"
#include "platform/scene/contact/params.h"

namespace godobject {
namespace {

/// Relative tolerance of a sphere's radius, for numbers rounded in a file.
constexpr double radius_tolerance = 1e-3;

/// A corner of a box, the ball at an end of a capsule, or a whole ball.
struct Tip {
  Vec3 p_B;
  double radius = 0;
};

std::vector<Tip> tips_of(const ShapeConfig& shape) {
  std::vector<Tip> tips;
  if (shape.kind == ShapeKind::box) {
    const Vec3 half = shape.half_extents.value_or(Vec3::Zero());
    for (int k = 0; k < 8; ++k)
      tips.push_back({.p_B = shape.X.p + shape.X.q * half.cwiseProduct(Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1,
                                                                            k & 4 ? 1 : -1))});
    return tips;
  }
  const double radius = shape.radius.value_or(0), half_length = shape.half_length.value_or(0);
  for (const double side : {-1.0, 1.0})
    tips.push_back({.p_B = shape.X.p + shape.X.q * Vec3(0, 0, side * half_length), .radius = radius});
  return tips;
}

/// True if one sphere of the body, its radius multiplied by `times`, contains all tips.
bool is_held(const BodyConfig& body, const Tip* first, const Tip* end, double times) {
  for (const SphereConfig& row : body.spheres)
    for (int i = 0; i < row.count; ++i) {
      const Vec3 p_B = row.p_B + i * row.spacing;
      if (std::all_of(first, end, [&](const Tip& tip) {
            return (tip.p_B - p_B).norm() + tip.radius <= times * (1 + radius_tolerance) * row.radius;
          }))
        return true;
    }
  return false;
}

/// Distance from the centre of a sphere tangent to three faces of a box to their corner, in radii.
const double inset = std::sqrt(3.0);

ShapeCover cover_of(const BodyConfig& body, const ShapeConfig& shape) {
  const std::vector<Tip> tips = tips_of(shape);
  const Tip *const first = tips.data(), *const end = first + tips.size();
  if (is_held(body, first, end, 1)) return ShapeCover::whole;
  for (const Tip* tip = first; tip != end; ++tip)
    if (!is_held(body, tip, tip + 1, inset)) return ShapeCover::none;
  return ShapeCover::tips;
}

bool is_of_boxes(const BodyConfig& body) {
  return std::ranges::all_of(body.shapes, [](const ShapeConfig& s) { return s.kind == ShapeKind::box; });
}

ShapeParams in_world(const Surface& surface, const SceneConfig& scene) {
  ShapeParams shape = surface.shape;
  if (surface.body == world) return shape;
  const Pose& X_WB = scene.bodies[surface.body].X_WB;
  shape.X_WS = {.p = X_WB.p + X_WB.q * shape.X_WS.p, .q = X_WB.q * shape.X_WS.q};
  return shape;
}

}  // namespace

ShapeCover shape_cover(const BodyConfig& body) {
  ShapeCover least = ShapeCover::whole;
  for (const ShapeConfig& shape : body.shapes) least = std::min(least, cover_of(body, shape));
  return least;
}

bool meets_obstacle(ShapeCover cover, ShapeKind obstacle) {
  return cover >= (obstacle == ShapeKind::plane ? ShapeCover::tips : ShapeCover::whole);
}

bool meet_each_other(const BodyConfig& a, const BodyConfig& b) {
  const ShapeCover of_a = shape_cover(a), of_b = shape_cover(b);
  if (of_a == ShapeCover::whole || of_b == ShapeCover::whole) return true;
  return of_a == ShapeCover::tips && of_b == ShapeCover::tips && is_of_boxes(a) && is_of_boxes(b);
}

std::vector<SpheresAlone> spheres_alone(const SceneConfig& scene) {
  const std::vector<std::size_t> tools = tools_of(scene);
  std::vector<SpheresAlone> all;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const BodyConfig& body = scene.bodies[i];
    SpheresAlone one{.body = body.name, .other = {}};
    const auto add = [&](const std::string& other) {
      if (one.num_others++ == 0) one.other = other;
    };
    const ShapeCover cover = shape_cover(body);
    for (const ObstacleConfig& obstacle : scene.obstacles)
      if (!meets_obstacle(cover, obstacle.shape.kind)) add("obstacle '" + obstacle.name + "'");
    for (std::size_t j = i + 1; j < scene.bodies.size(); ++j)
      if (tools[i] != tools[j] && !meet_each_other(body, scene.bodies[j]))
        add("the shape of body '" + scene.bodies[j].name + "'");
    if (one.num_others > 0) all.push_back(std::move(one));
  }
  return all;
}

BuriedSpheres buried_spheres(const SceneConfig& scene) {
  const SceneContacts contacts = scene_contacts(scene);
  const std::vector<std::size_t> tools = tools_of(scene);
  constexpr double anywhere = std::numeric_limits<double>::infinity();
  std::vector<ShapeParams> shapes;
  for (const Surface& surface : contacts.surfaces) shapes.push_back(in_world(surface, scene));
  BuriedSpheres buried;
  for (const BodySphere& sphere : contacts.spheres) {
    const BodyConfig& body = scene.bodies[sphere.body];
    const Vec3 p_W = body.X_WB.p + body.X_WB.q * sphere.p_B;
    double deepest = 0;
    for (std::size_t s = 0; s < shapes.size(); ++s) {
      const std::size_t other = contacts.surfaces[s].body;
      if (other != world && tools[other] == tools[sphere.body]) continue;
      const double distance = nearest(shapes[s], p_W, anywhere).distance;
      if (!(distance < deepest)) continue;
      deepest = distance;
      if (sphere.radius - distance <= buried.depth) continue;
      buried.depth = sphere.radius - distance;
      buried.deepest = "sphere of body '" + body.name + "' in " + contacts.surface_names[s];
    }
    if (deepest < 0) ++buried.num;
  }
  return buried;
}

}  // namespace godobject
