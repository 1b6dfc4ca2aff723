#include "platform/scene/checks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "core/shape/faces.h"
#include "core/shape/points.h"
#include "platform/scene/contact/params.h"
#include "platform/scene/keys/joint.h"

namespace godobject {
namespace {

using Box = Eigen::AlignedBox3d;

Vec3 principal_moments(const BodyConfig& body) {
  return Eigen::SelfAdjointEigenSolver<Mat3>(body.inertia, Eigen::EigenvaluesOnly).eigenvalues();
}

/// Returns the largest distance of a solid's points from its centre, m.
double reach_of(const ShapeConfig& shape) {
  return shape.half_extents.value_or(Vec3::Zero()).norm() + shape.radius.value_or(0) +
         shape.half_length.value_or(0);
}

double volume_of(const ShapeConfig& shape) {
  if (shape.half_extents) return 8 * shape.half_extents->prod();
  const double r = shape.radius.value_or(0);
  return std::numbers::pi * r * r * (4 * r / 3 + 2 * shape.half_length.value_or(0));
}

/// Calls f(centre, radius) for the first and the last sphere of each row.
template <class F>
void for_ends(const BodyConfig& body, F f) {
  for (const SphereConfig& row : body.spheres) {
    f(row.p_B, row.radius);
    f(Vec3(row.p_B + (row.count - 1) * row.spacing), row.radius);
  }
}

/// Returns R, the largest distance of spheres and shapes from the centre of mass, m.
double reach_of(const BodyConfig& body) {
  double R = 0;
  for_ends(body, [&](const Vec3& p_B, double radius) { R = std::max(R, p_B.norm() + radius); });
  for (const ShapeConfig& shape : body.shapes) R = std::max(R, shape.X.p.norm() + reach_of(shape));
  return R;
}

/// Returns the radius of gyration: r_g^2 = I_max / m.
double gyration_of(const BodyConfig& body) {
  return std::sqrt(principal_moments(body).maxCoeff() / body.mass);
}

bool gyrates_near(const BodyConfig& body, double R) {
  const double r_g = gyration_of(body);
  return r_g >= min_gyration * R && r_g <= max_gyration * R;
}

/// Returns the volume of the homogeneous ellipsoid with semi-axes a_i^2 = 5 (I_j + I_k - I_i) / (2 m).
/// Returns 0 without the triangle inequality, of which another check warns.
double volume_of_ellipsoid(const BodyConfig& body) {
  const Vec3 I = principal_moments(body);
  const Vec3 squares = 5 / (2 * body.mass) * (Vec3::Constant(I.sum()) - 2 * I);
  return squares.minCoeff() <= 0 ? 0 : 4 * std::numbers::pi / 3 * std::sqrt(squares.prod());
}

/// Bounds of the volume of a body's mass, m^3; 0: unknown.
struct Volumes {
  double least = 0, most = 0;
};

Volumes volumes_of(const BodyConfig& body) {
  double of_shapes = 0;
  for (const ShapeConfig& shape : body.shapes) of_shapes += volume_of(shape);
  Box box;
  for_ends(body, [&](const Vec3& p_B, double radius) {
    box.extend(Vec3(p_B + Vec3::Constant(radius)));
    box.extend(Vec3(p_B - Vec3::Constant(radius)));
  });
  const double drawn = std::max(of_shapes, box.isEmpty() ? 0 : box.volume());
  const double R = reach_of(body), r_g = gyration_of(body);
  const bool is_shaped = of_shapes > 0 && r_g <= R;  // no mass lies beyond its shapes
  if (is_shaped || (R > 0 && !gyrates_near(body, R))) return {drawn, drawn};
  return {.least = std::max(drawn, volume_of_ellipsoid(body)),
          .most = std::max(drawn, 4 * std::numbers::pi / 3 * r_g * r_g * r_g)};
}

std::string expected(double least, double most, const char* unit) {
  return "expected are " + shortest_plain(least) + " to " + shortest_plain(most) + " " + unit;
}

/// True if one sphere of the body rounds all points of the shape, or the shape is a ball.
bool is_within_sphere(const BodyConfig& body, const ShapeConfig& config) {
  const ShapeParams shape = shape_params(config);
  if (shape.kind == ShapeKind::sphere) return true;
  for (const SphereConfig& row : body.spheres)
    for (int i = 0; i < row.count; ++i) {
      const Vec3 p_S = to_body(shape.X_WS.q, row.p_B + i * row.spacing - shape.X_WS.p);
      const double farthest =
          shape.kind == ShapeKind::box
              ? (p_S.cwiseAbs() + shape.half_extents).norm()
              : Vec3(p_S.x(), p_S.y(), std::abs(p_S.z()) + shape.half_length).norm() + shape.radius;
      if (farthest <= (1 + rounding_tolerance) * row.radius) return true;
    }
  return false;
}

ShapeParams in_world(const Surface& surface, const SceneConfig& scene) {
  ShapeParams shape = surface.shape;
  if (surface.body == world) return shape;
  const Pose& X_WB = scene.bodies[surface.body].X_WB;
  shape.X_WS = {.p = X_WB.p + X_WB.q * shape.X_WS.p, .q = X_WB.q * shape.X_WS.q};
  return shape;
}

}  // namespace

// ---- units and sizes ------------------------------------------------------------------------------

std::string doubt_of_gyration(const BodyConfig& body) {
  const double R = reach_of(body);
  if (R == 0 || gyrates_near(body, R)) return "";
  return "gives body '" + body.name + "' a radius of gyration of " + rounded(gyration_of(body)) +
         " m, and its spheres and shapes reach " + rounded(R) + " m; " +
         expected(min_gyration, max_gyration, "times their reach") +
         ": give inertia in kg m^2, mass in kg, lengths in m";
}

std::string doubt_of_density(const BodyConfig& body) {
  const Volumes V = volumes_of(body);
  const bool light = V.least > 0 && body.mass < min_density * V.least;
  const bool heavy = V.most > 0 && body.mass > max_density * V.most;
  if (!light && !heavy) return "";
  const double volume = light ? V.least : V.most;
  return "gives body '" + body.name + "' a density of " + rounded(body.mass / volume) + " kg/m^3, " +
         rounded(body.mass) + " kg in " + rounded(volume) + " m^3; " +
         expected(min_density, max_density, "kg/m^3") + ": give mass in kg, lengths in m, inertia in kg m^2";
}

std::string doubt_of_density(double surface_density, double thickness) {
  if (surface_density > max_surface_density)
    return "is " + rounded(surface_density) + " kg/m^2 of surface density; expected are at most " +
           shortest_plain(max_surface_density) + " kg/m^2: give mass in kg, lengths in m";
  const double density = surface_density / thickness;
  if (!(thickness > 0 && surface_density > 0) || (density >= min_density && density <= max_density))
    return "";
  return "is a density of " + rounded(density) + " kg/m^3, " + rounded(surface_density) +
         " kg/m^2 over a thickness of " + rounded(thickness) + " m; " +
         expected(min_density, max_density, "kg/m^3") + ": give mass in kg, lengths in m";
}

std::string doubt_of_size(const MeshData& mesh, const std::string& owner) {
  Box box;
  for (const Vec3& vertex : mesh.vertices) box.extend(vertex);
  if (box.isEmpty()) return "";
  const double size = box.sizes().maxCoeff();
  if (size >= min_mesh_size && size <= max_mesh_size) return "";
  return "mesh of " + owner + " is " + rounded(size) + " m long; " +
         expected(min_mesh_size, max_mesh_size, "m") +
         ": 'scale' is the length of one unit of its file in m, 0.001 for mm";
}

// ---- shapes that touch meshes only with their points ---------------------------------------------------

bool meets_obstacle(const BodyConfig& body, ShapeKind obstacle) {
  return !has_faces(obstacle) || std::ranges::all_of(body.shapes, [&](const ShapeConfig& shape) {
    return is_within_sphere(body, shape);
  });
}

std::vector<SpheresAlone> spheres_alone(const SceneConfig& scene) {
  std::vector<SpheresAlone> all;
  for (const BodyConfig& body : scene.bodies) {
    SpheresAlone one{.body = body.name, .other = {}};
    for (const ObstacleConfig& obstacle : scene.obstacles)
      if (!meets_obstacle(body, obstacle.shape.kind) && one.num_others++ == 0)
        one.other = "obstacle '" + obstacle.name + "'";
    if (one.num_others > 0) all.push_back(std::move(one));
  }
  return all;
}

namespace {

/// Calls f(p_S, r) for the largest balls in a shape at its centre and in its corners and ends. p_S: centre of
/// a ball in the shape's frame, m.
template <class F>
void each_ball_in(const ShapeParams& shape, F f) {
  const double r = half_thickness(shape);
  f(Vec3(Vec3::Zero()), r);
  if (shape.kind == ShapeKind::capsule)
    for (const double z : {-shape.half_length, shape.half_length}) f(Vec3(0, 0, z), r);
  if (shape.kind != ShapeKind::box) return;
  for (int j = 0; j < 8; ++j) {
    const Vec3 side((j & 1) != 0 ? 1 : -1, (j & 2) != 0 ? 1 : -1, (j & 4) != 0 ? 1 : -1);
    f(side.cwiseProduct(Vec3(shape.half_extents - Vec3::Constant(r))), r);
  }
}

}  // namespace

BuriedSolids buried_solids(const SceneConfig& scene) {
  const SceneContacts contacts = scene_contacts(scene);
  const std::vector<std::size_t> tools = tools_of(scene);
  constexpr double anywhere = std::numeric_limits<double>::infinity();
  std::vector<ShapeParams> shapes;
  for (const Surface& surface : contacts.surfaces) shapes.push_back(in_world(surface, scene));
  BuriedSolids buried;
  // true if the centre of a ball of this body is inside a solid
  const auto is_buried = [&](std::size_t body, const char* kind, const Vec3& p_W, double radius) {
    double deepest = 0;
    for (std::size_t s = 0; s < shapes.size(); ++s) {
      const std::size_t other = contacts.surfaces[s].body;
      if (other != world && tools[other] == tools[body]) continue;
      const double distance = nearest(shapes[s], p_W, anywhere).distance;
      if (!(distance < deepest)) continue;
      deepest = distance;
      if (radius - distance <= buried.depth) continue;
      buried.depth = radius - distance;
      buried.deepest = kind + (" of body '" + scene.bodies[body].name) + "' in " + contacts.surface_names[s];
    }
    return deepest < 0;
  };
  for (const BodySphere& sphere : contacts.spheres) {
    const Pose& X_WB = scene.bodies[sphere.body].X_WB;
    if (is_buried(sphere.body, "sphere", X_WB.p + X_WB.q * sphere.p_B, sphere.radius)) ++buried.num;
  }
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    const std::size_t body = contacts.surfaces[s].body;
    if (body == world) continue;
    bool any = false;
    each_ball_in(shapes[s], [&](const Vec3& p_S, double r) {
      any = is_buried(body, "shape", shapes[s].X_WS.p + shapes[s].X_WS.q * p_S, r) || any;
    });
    if (any) ++buried.num;
  }
  return buried;
}

}  // namespace godobject
