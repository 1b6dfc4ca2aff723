// Speed up to which the contacts of a scene let nothing pass.
//
// A sphere of radius r touches a solid that is 2 T thick at its thinnest. T is half a box's shortest edge, or
// the radius of a sphere or capsule. For a mesh it is at most the reach of a query inside; for a plane it is
// infinite. Beyond the middle the nearest surface is the far one, where the contact pushes the sphere out. So
//
//   travel:  a contact is found if the centre ends a step within (-T, r) of the surface.
//            Steps of h v cannot skip this range if                                  h v < r + T
//   energy:  the tool's m v^2 / 2 is absorbed by one contact below the depth r + T: v < (r + T) sqrt(k / m)
//
// Swept contacts hold at higher travels too: spheres against obstacles, and against boxes of bodies (decision
// 042).
//
// Edges of boxes on two bodies cross without spheres, and are searched at the predicted end of a step.
// Spheres are swept, so that a box leaves another by its face of entry. Boxes that overlap by T / 2 along
// every axis do not separate again. In tests with v of the fastest points of the boxes, pairs hold if
//
//   boxes:   h v < 0.3 T,  v < (T / 2) sqrt(k / m)
//
// m: mass of the whole tool, with another tool m_1 m_2 / (m_1 + m_2).
// k: stiffness of one sphere's contact, without damping.
//
// A hand that keeps pushing has a bound of its own. Its target x_H deep is held if the coupling k_c balances
// the contact at less than r + T: x_H < (r + T) (1 + k / k_c). A prescribed body, placed at its target
// in every step, is stopped by nothing. Only the travel bounds it, and only against bodies that it can push.
//
// Points of a shape, its corners, ends or centre, touch as spheres do, those of a corner with r = 0:
//
//   shapes:  r_a + T_b and r_b + T_a, whichever is less, in place of r + T
//
// Not included: shapes against meshes (spheres_alone()), and nodes of nets.
// Obstacles stop nodes at any speed. But the carrier and other nodes pull them on by springs, with a force
// that depends on the deformation of the whole net.
#include "platform/scene/checks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/contact/candidates.h"
#include "platform/scene/contact/params.h"

namespace godobject {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr std::size_t max_rays = 2000;
/// Share of the half thickness of the thinner box, see above, tests/core/contact/test_tunnelling.cc and
/// decision 042.
constexpr double held_in_a_step = 0.3;

/// Returns the distance from p along the unit vector d to the triangle (Moeller, Trumbore 1997); infinite if
/// it is missed.
double way_to(const Vec3& p, const Vec3& d, const Corners& t) {
  const Vec3 a = t[1] - t[0], b = t[2] - t[0], q = d.cross(b), o = p - t[0];
  const double det = a.dot(q);
  const double u = o.dot(q) / det, v = d.dot(o.cross(a)) / det, way = b.dot(o.cross(a)) / det;
  return u >= 0 && v >= 0 && u + v <= 1 && way > 0 ? way : infinite;
}

/// Returns T for a sphere of radius r.
double half_thickness_at(const ShapeParams& shape, double r) {
  switch (shape.kind) {
    case ShapeKind::box: return shape.half_extents.minCoeff();
    case ShapeKind::sphere:
    case ShapeKind::capsule: return shape.radius;
    case ShapeKind::height_field: {
      const HeightField& f = *shape.height_field;
      return f.spacing * (std::min(f.columns, f.rows) - 1) / 2;
    }
    default: return shape.kind == ShapeKind::mesh ? r + contact_reach * r : infinite;
  }
}

/// Mass and coupling stiffness of a body's tool.
struct ToolSums {
  double mass = 0, k_c = 0;  // kg, N/m
};

std::vector<ToolSums> tool_sums(const SceneConfig& scene, const std::vector<std::size_t>& tools) {
  std::vector<ToolSums> sums(scene.bodies.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    ToolSums& sum = sums[tools[i]];
    sum.mass += scene.bodies[i].mass;
    if (scene.bodies[i].coupling) sum.k_c += scene.bodies[i].coupling->k;
  }
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] = sums[tools[i]];
  return sums;
}

class Search {
 public:
  explicit Search(const SceneConfig& scene)
      : scene_(scene),
        contacts_(scene_contacts(scene)),
        tools_(tools_of(scene)),
        sums_(tool_sums(scene, tools_)) {
    for (const std::unique_ptr<MeshSolid>& solid : contacts_.meshes)
      if (solid) thinnest_.emplace_back(&solid->mesh(), thinnest(solid->data()));
  }

  std::optional<SpeedBound> slowest() {
    for (const BodySphere& sphere : contacts_.spheres) {
      for (std::size_t s = 0; s < contacts_.surfaces.size(); ++s) against_surface(sphere, s);
      for (const BodySphere& other : contacts_.spheres) against_sphere(sphere, other);
    }
    for (const Surface& a : contacts_.surfaces)
      for (const Surface& b : contacts_.surfaces)
        if (a.body < b.body && b.body != world) of_boxes(a, b);
    for (std::size_t a = 0; a < contacts_.surfaces.size(); ++a)
      for (std::size_t b = 0; b < contacts_.surfaces.size(); ++b) of_points(a, b);
    return slowest_;
  }

 private:
  void against_surface(const BodySphere& sphere, std::size_t s) {
    const Surface& surface = contacts_.surfaces[s];
    if (!meets(sphere.body, surface)) return;
    double T = half_thickness_at(surface.shape, sphere.radius);
    for (const auto& [mesh, thickness] : thinnest_)
      if (surface.shape.mesh == mesh) T = std::min(T, thickness / 2);
    take(sphere, surface.material, surface.body, T, contacts_.surface_names[s]);
  }

  void against_sphere(const BodySphere& sphere, const BodySphere& other) {
    if (tools_[sphere.body] == tools_[other.body] || !scene_.bodies[other.body].shapes.empty()) return;
    take(sphere, other.material, other.body, other.radius,
         "sphere of body '" + scene_.bodies[other.body].name + "'");
  }

  /// Bounds the speed of two boxes, whose edges cross.
  void of_boxes(const Surface& a, const Surface& b) {
    if (a.shape.kind != ShapeKind::box || b.shape.kind != ShapeKind::box || tools_[a.body] == tools_[b.body])
      return;
    if (is_prescribed(a.body) && is_prescribed(b.body)) return;
    const double T = std::min(a.shape.half_extents.minCoeff(), b.shape.half_extents.minCoeff());
    const Springs springs = springs_between(a.body, b.body, contacts_.laws[a.material][b.material].k);
    keep({.what =
              "boxes of bodies '" + scene_.bodies[a.body].name + "' and '" + scene_.bodies[b.body].name + "'",
          .travel = held_in_a_step * T / scene_.step,
          .energy = springs.speed_within(sunk_depth * T),
          .hand = springs.hand_within(sunk_depth * T)});
  }

  /// Bounds the speed of two shapes, of a body and of another or the world, whose points touch.
  void of_points(std::size_t s, std::size_t o) {
    const Surface &a = contacts_.surfaces[s], &b = contacts_.surfaces[o];
    const bool on_world = b.body == world;
    if (a.body == world || (!on_world && (b.body < a.body || tools_[a.body] == tools_[b.body]))) return;
    if (!is_carried(b.shape.kind) || is_prescribed(a.body) || (!on_world && is_prescribed(b.body))) return;
    if (!on_world && a.shape.kind == ShapeKind::box && b.shape.kind == ShapeKind::box) return;  // of_boxes()
    const double depth = std::min(round_radius(a.shape) + half_thickness(b.shape),
                                  round_radius(b.shape) + half_thickness(a.shape));
    const Springs springs = springs_between(a.body, b.body, contacts_.laws[a.material][b.material].k);
    keep({.what = contacts_.surface_names[s] + " and " + contacts_.surface_names[o],
          .travel = depth / scene_.step,
          .energy = springs.speed_within(depth),
          .hand = springs.hand_within(depth)});
  }

  /// True if a body may touch a surface, except an obstacle that parts of its shapes do not touch.
  bool meets(std::size_t body, const Surface& surface) const {
    if (surface.body == world) return meets_obstacle(scene_.bodies[body], surface.shape.kind);
    return tools_[surface.body] != tools_[body];
  }

  /// True if the body is placed at its target, regardless of contacts.
  bool is_prescribed(std::size_t body) const {
    return scene_.coupling == CouplingMode::imposed && sums_[body].k_c > 0;
  }

  /// A contact of two tools, or of a tool and the world, and the couplings that press it.
  struct Springs {
    double k = 0, mass = 0, k_c = 0;  // N/m; kg; N/m, infinite for a body placed at its target
    /// Returns the speed that the contact stops within a depth.
    double speed_within(double depth) const {
      return k_c < infinite ? depth * std::sqrt(k / mass) : infinite;
    }
    /// Returns the distance beyond the surface to which a hand may pull a tool that stays within a depth.
    double hand_within(double depth) const {
      return k_c > 0 && k_c < infinite ? depth * (1 + k / k_c) : infinite;
    }
  };
  Springs springs_between(std::size_t body, std::size_t other, double k) const {
    Springs springs{.k = k, .mass = sums_[body].mass, .k_c = sums_[body].k_c};
    if (other != world) {
      springs.mass = springs.mass * sums_[other].mass / (springs.mass + sums_[other].mass);
      springs.k_c = std::max(springs.k_c, sums_[other].k_c);
    }
    if (is_prescribed(body) || (other != world && is_prescribed(other))) springs.k_c = infinite;
    return springs;
  }

  /// Bounds the travel of a prescribed body, which nothing stops. It passes obstacles at any speed, but must
  /// touch a movable body in some step.
  void take_prescribed(const BodySphere& sphere, std::size_t other, double depth, const std::string& name) {
    if (other == world || (is_prescribed(sphere.body) && is_prescribed(other))) return;
    keep({.what = what(sphere, name), .travel = depth / scene_.step, .energy = infinite, .hand = infinite});
  }

  std::string what(const BodySphere& sphere, const std::string& name) const {
    return "sphere of body '" + scene_.bodies[sphere.body].name + "' and " + name;
  }

  void keep(const SpeedBound& bound) {
    if (!slowest_ || bound.top() < slowest_->top()) slowest_ = bound;
  }

  void take(const BodySphere& sphere, MaterialId material, std::size_t other, double T,
            const std::string& name) {
    const double k = contacts_.laws[sphere.material][material].k, depth = sphere.radius + T;
    if (is_prescribed(sphere.body) || (other != world && is_prescribed(other)))
      return take_prescribed(sphere, other, depth, name);
    const Springs springs = springs_between(sphere.body, other, k);
    keep({.what = what(sphere, name),
          .travel = depth / scene_.step,
          .energy = springs.speed_within(depth),
          .hand = springs.hand_within(depth)});
  }

  const SceneConfig& scene_;
  SceneContacts contacts_;
  std::vector<std::size_t> tools_;
  std::vector<ToolSums> sums_;
  std::vector<std::pair<const TriangleMesh*, double>> thinnest_;
  std::optional<SpeedBound> slowest_;
};

}  // namespace

double thinnest(const MeshData& mesh) {
  const auto corners = [&](const TriangleIndices& t) {
    return Corners{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
  };
  const std::size_t stride = (mesh.triangles.size() + max_rays - 1) / max_rays;
  double shortest_way = infinite;
  for (std::size_t from = 0; from < mesh.triangles.size(); from += stride) {
    const Corners t = corners(mesh.triangles[from]);
    const Vec3 centre = (t[0] + t[1] + t[2]) / 3;
    const Vec3 inward = -(t[1] - t[0]).cross(t[2] - t[0]).normalized();
    for (std::size_t to = 0; to < mesh.triangles.size(); ++to)
      if (to != from)
        shortest_way = std::min(shortest_way, way_to(centre, inward, corners(mesh.triangles[to])));
  }
  return shortest_way;
}

const char* what_does_not_pass(const SceneConfig& scene) {
  const bool nets = !scene.nets.empty();
  if (spheres_alone(scene).empty()) return nets ? "nothing (nodes of nets excepted)" : "nothing";
  return nets ? "nothing (nodes of nets and shapes against meshes excepted)"
              : "nothing (shapes against meshes excepted)";
}

std::string top_speed_text(const SceneConfig& scene) {
  const std::optional<SpeedBound> bound = top_speed(scene);
  if (!bound) {
    const std::vector<SpheresAlone> alone = spheres_alone(scene);
    if (alone.empty()) return "";
    return "not bounded: the shape of body '" + alone[0].body + "' touches " + alone[0].other +
           " only with its corners, ends and spheres";
  }
  if (std::isinf(bound->top())) return "no limit: only planes can be touched, and they have no other side";
  std::array<char, 32> top{};
  std::snprintf(top.data(), top.size(), "%.3g", bound->top());
  return std::string(top.data()) + " m/s: up to this speed " + what_does_not_pass(scene) +
         " passes through a solid, " + bound->what;
}

std::optional<SpeedBound> top_speed(const SceneConfig& scene) {
  if (contact_scope(scene) == ContactScope::none) return std::nullopt;
  return Search(scene).slowest();
}

}  // namespace godobject
