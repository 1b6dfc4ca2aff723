#include "platform/view/solids.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "core/shape/height_field.h"

namespace godobject {
namespace {

/// Returns the height field as triangles, with sides and without a bottom, as in the contact search.
MeshData mesh_of(const HeightGrid& grid, double spacing) {
  MeshData mesh;
  const std::uint32_t n = grid.columns, m = grid.rows;
  for (std::uint32_t j = 0; j < m; ++j)
    for (std::uint32_t i = 0; i < n; ++i)
      mesh.vertices.emplace_back(i * spacing, j * spacing, grid.height[std::size_t{j} * n + i]);
  for (std::uint32_t j = 0; j + 1 < m; ++j)
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      const std::uint32_t a = j * n + i, b = a + 1, c = a + n, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  return mesh;
}

SolidKind kind_of(ShapeKind kind) noexcept {
  switch (kind) {
    case ShapeKind::plane: return SolidKind::plane;
    case ShapeKind::box: return SolidKind::box;
    case ShapeKind::sphere: return SolidKind::sphere;
    case ShapeKind::capsule: return SolidKind::capsule;
    case ShapeKind::height_field:
    case ShapeKind::mesh: break;
  }
  return SolidKind::mesh;
}

Solid solid_of(const ShapeConfig& shape, SolidRole role, const std::string& name) {
  Solid solid{.kind = kind_of(shape.kind), .role = role, .name = name, .X = shape.X};
  const double radius = shape.radius.value_or(0);
  solid.size = shape.half_extents.value_or(Vec3(radius, shape.half_length.value_or(0), 0));
  return solid;
}

void add(const ObstacleConfig& obstacle, Drawing& to) {
  Solid solid = solid_of(obstacle.shape, SolidRole::obstacle, obstacle.name);
  if (solid.kind == SolidKind::mesh) {
    solid.mesh = to.meshes.size();
    const bool is_field = obstacle.shape.kind == ShapeKind::height_field;
    to.meshes.push_back(is_field ? mesh_of(obstacle.heights, obstacle.spacing.value_or(1)) : obstacle.mesh);
  }
  if (obstacle.centres.empty()) to.solids.push_back(solid);
  for (const Vec3& centre : obstacle.centres) {
    solid.X.p = obstacle.shape.X.p + obstacle.shape.X.q * centre;
    to.solids.push_back(solid);
  }
}

void add(const BodyConfig& body, std::size_t index, Drawing& to) {
  const auto put = [&](Solid solid) {
    solid.body = index;
    solid.name = body.name;
    to.solids.push_back(std::move(solid));
  };
  for (const ShapeConfig& shape : body.shapes) put(solid_of(shape, SolidRole::shape, body.name));
  if (body.shapes.empty()) put(solid_of_inertia(body.mass, body.inertia));
  for (const SphereConfig& row : body.spheres)
    for (int i = 0; i < row.count; ++i)
      put({.kind = SolidKind::sphere,
           .role = SolidRole::contact,
           .X = {.p = row.p_B + i * row.spacing, .q = Quat::Identity()},
           .size = Vec3(row.radius, 0, 0)});
}

bool about_equal(double a, double b) noexcept {
  constexpr double tolerance = 0.01;
  return std::abs(a - b) <= tolerance * std::max(a, b);
}

}  // namespace

Solid solid_of_inertia(double mass, const Mat3& inertia) {
  const Eigen::SelfAdjointEigenSolver<Mat3> axes(inertia);
  const Vec3& I = axes.eigenvalues();  // in ascending order
  Mat3 R = axes.eigenvectors();
  const auto root = [](double a) { return std::sqrt(std::max(a, 0.0)); };
  Solid solid{.role = SolidRole::inertia};
  if (about_equal(I.x(), I.z())) {  // I = 2/5 m r^2
    solid.kind = SolidKind::sphere;
    solid.size = Vec3(root(2.5 * I.mean() / mass), 0, 0);
    return solid;
  }
  const bool rod = about_equal(I.y(), I.z()), disc = about_equal(I.x(), I.y());
  if (rod || disc) {  // about z: I_z = m r^2 / 2, I_x = m (3 r^2 + l^2) / 12
    const double I_z = rod ? I.x() : I.z(), I_x = rod ? I.z() : I.x();
    const double r_sq = 2 * I_z / mass, l_sq = 12 * I_x / mass - 3 * r_sq;
    solid.kind = SolidKind::cylinder;
    solid.size = Vec3(root(r_sq), 0.5 * root(l_sq), 0);
    const Vec3 z = R.col(rod ? 0 : 2);
    solid.X.q = turn_from_z(z.z() < 0 ? Vec3(-z) : z);
    return solid;
  }
  // I_x = m (b^2 + c^2) / 3 of half extents a, b, c: a^2 = 3 (I_y + I_z - I_x) / 2 m
  for (int i = 0; i < 3; ++i) solid.size[i] = root(1.5 * (I.sum() - 2 * I[i]) / mass);
  if (R.determinant() < 0) R.col(0) = -R.col(0);
  solid.X.q = Quat(R);
  return solid;
}

Drawing drawing_of(const SceneConfig& scene) {
  Drawing drawing;
  for (const ObstacleConfig& obstacle : scene.obstacles) add(obstacle, drawing);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) add(scene.bodies[i], i, drawing);
  return drawing;
}

}  // namespace godobject
