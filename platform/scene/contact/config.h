// Contacts in a scene file: spheres and shapes of bodies, obstacles, pairs of materials.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/contact/contact.h"
#include "core/shape/list.h"

namespace godobject {

inline constexpr const char* default_material = "default";

/// A row of equal spheres on a body; one sphere if count is 1.
struct SphereConfig {
  Vec3 p_B = Vec3::Zero();  // centre of the first, m, body axes about the centre of mass
  double radius = 0;        // m, > 0
  std::string material = default_material;
  int count = 1;                // >= 1
  Vec3 spacing = Vec3::Zero();  // vector from one centre to the next, m, body axes
};

/// A solid. Each kind has only the dimensions that it requires.
struct ShapeConfig {
  ShapeKind kind = ShapeKind::box;
  Pose X;  // body shape: in body axes about the centre of mass; obstacle: in the world
  std::optional<Vec3> half_extents;   // box: m, > 0
  std::optional<double> radius;       // sphere, capsule: m, > 0
  std::optional<double> half_length;  // capsule: m, >= 0
  std::string material = default_material;
};

/// Triangles, counter-clockwise seen from outside.
struct MeshData {
  std::vector<Vec3> vertices;  // m
  std::vector<TriangleIndices> triangles;
};

/// Heights over a grid: column i, row j stands at x = i spacing, y = j spacing.
struct HeightGrid {
  std::vector<Real> height;  // row by row, m
  std::uint32_t columns = 0, rows = 0;
};

/// An obstacle, fixed in the world.
struct ObstacleConfig {
  std::string name;
  ShapeConfig shape;
  std::string file;             // name of the file of a mesh, height field or many spheres; empty without one
  std::optional<double> scale;  // m per unit of a mesh file
  std::optional<double> spacing;  // m, distance of neighbours in a height field's grid
  // Contents of the file.
  MeshData mesh;
  HeightGrid heights;
  std::vector<Vec3> centres;  // m, centres of the spheres in the axes of shape.X
};

/// Law of a contact between two materials (22), (23).
struct ContactConfig {
  std::vector<std::string> materials;  // two, in any order; may be equal
  ContactLaw law{};                    // of each sphere
};

}  // namespace godobject
