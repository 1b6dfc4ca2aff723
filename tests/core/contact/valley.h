// Drawn valleys and strips, as meshes and height fields.
#pragma once

#include <stdexcept>

#include "tests/core/contact/contact_scene.h"
#include "tests/core/mesh_arrays.h"
#include "tests/oracle/nearest_point.h"

namespace godobject::valley {

inline constexpr Real radius = 0.005;  // m

/// A closed surface.
struct Solid : MeshArrays {
  Solid() = default;
  Solid(const Solid&) = delete;
  Solid& operator=(const Solid&) = delete;

  void add_quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    triangles.push_back({a, b, c});
    triangles.push_back({a, c, d});
  }
  void set_up(Real spacing) {
    if (MeshArrays::set_up(spacing, 200000, 2000000).invalid != MeshInvalid::nothing)
      throw std::runtime_error("the drawn surface is no valid mesh");
  }
  oracle::Solid twin() const { return oracle::mesh(vertices, triangles); }
};

/// A block whose upper side follows a profile along x, in strips along y between the given places.
inline std::unique_ptr<Solid> block_below(const std::vector<Vec3>& profile, const std::vector<Real>& ys) {
  auto solid = std::make_unique<Solid>();
  const auto columns = static_cast<std::uint32_t>(profile.size()),
             rows = static_cast<std::uint32_t>(ys.size());
  Real low = profile[0].z();
  for (const Vec3& p : profile) low = std::min(low, p.z());
  for (const bool below : {false, true})
    for (const Real y : ys)
      for (const Vec3& p : profile) solid->vertices.push_back({p.x(), y, below ? low - 4 * radius : p.z()});
  const auto top = [&](std::uint32_t i, std::uint32_t j) { return j * columns + i; };
  const auto bottom = [&](std::uint32_t i, std::uint32_t j) { return (rows + j) * columns + i; };
  for (std::uint32_t j = 0; j + 1 < rows; ++j) {
    for (std::uint32_t i = 0; i + 1 < columns; ++i) {
      solid->add_quad(top(i, j), top(i + 1, j), top(i + 1, j + 1), top(i, j + 1));
      solid->add_quad(bottom(i, j), bottom(i, j + 1), bottom(i + 1, j + 1), bottom(i + 1, j));
    }
    solid->add_quad(top(0, j), top(0, j + 1), bottom(0, j + 1), bottom(0, j));
    const std::uint32_t end = columns - 1;
    solid->add_quad(top(end, j), bottom(end, j), bottom(end, j + 1), top(end, j + 1));
  }
  for (std::uint32_t i = 0; i + 1 < columns; ++i) {
    solid->add_quad(top(i, 0), bottom(i, 0), bottom(i + 1, 0), top(i + 1, 0));
    const std::uint32_t end = rows - 1;
    solid->add_quad(top(i, end), top(i + 1, end), bottom(i + 1, end), bottom(i, end));
  }
  solid->set_up(2 * radius);
  return solid;
}

/// A valley along y with its lowest line at x = 0, as a mesh, a height field, and two planes.
struct Valley {
  Real left, right;  // slopes, rad
  std::unique_ptr<Solid> solid;
  std::vector<Real> heights;
  HeightField field;
  static constexpr Real half_width = 8 * radius;

  Valley(Real on_left, Real on_right, Random& random) : left(on_left), right(on_right) {
    const Real z_left = half_width * std::tan(left), z_right = half_width * std::tan(right);
    std::vector<Real> ys{-half_width};
    while (ys.back() < half_width) ys.push_back(ys.back() + radius * random.uniform(0.3, 6));
    solid = block_below({Vec3(-half_width, 0, z_left), Vec3::Zero(), Vec3(half_width, 0, z_right)}, ys);
    for (int row = 0; row < 5; ++row) heights.insert(heights.end(), {z_left, 0, z_right});
    field = {.height = heights, .columns = 3, .rows = 5, .spacing = half_width};
  }
  Vec3 n_left() const { return {std::sin(left), 0, std::cos(left)}; }
  Vec3 n_right() const { return {-std::sin(right), 0, std::cos(right)}; }
  ShapeParams mesh() const {
    ShapeParams shape;
    shape.kind = ShapeKind::mesh;
    shape.mesh = &solid->mesh;
    return shape;
  }
  ShapeParams height_field() const {
    ShapeParams shape;
    shape.kind = ShapeKind::height_field;
    shape.X_WS.p = Vec3(-half_width, -2 * half_width, 0);
    shape.height_field = &field;
    return shape;
  }
  static ShapeParams plane(const Vec3& n) {
    ShapeParams shape;
    shape.X_WS.q = Quat::FromTwoVectors(Vec3::UnitZ(), n);
    return shape;
  }
};

}  // namespace godobject::valley
