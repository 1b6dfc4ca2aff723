// Drawable solids of a scene: shapes of bodies, contact spheres, and obstacles.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "platform/scene/scene.h"

namespace godobject {

enum class SolidKind : std::uint8_t { box, sphere, capsule, cylinder, plane, mesh };
inline constexpr std::array solid_kind_names{"box", "sphere", "capsule", "cylinder", "plane", "mesh"};

/// Meaning of a solid.
enum class SolidRole : std::uint8_t {
  shape,     // a shape of a body
  inertia,   // the solid of equal mass and inertia, for a body without shapes
  contact,   // a contact sphere of a body
  obstacle,  // fixed in the world
};
inline constexpr std::array solid_role_names{"shape", "inertia", "contact", "obstacle"};

struct Solid {
  SolidKind kind = SolidKind::box;
  SolidRole role = SolidRole::shape;
  std::optional<std::size_t> body{};  // absent: fixed in the world
  std::string name{};                 // name of the body or the obstacle
  Pose X{};                           // pose of the solid on its body, or in the world
  // box: half extents; sphere: radius, -, -; capsule, cylinder about z: radius, half length, -
  Vec3 size = Vec3::Zero();
  std::size_t mesh = 0;  // index in Drawing::meshes
};

struct Drawing {
  std::vector<Solid> solids;
  std::vector<MeshData> meshes;  // also of height fields
};

/// Returns the solids of the obstacles, then of the bodies.
Drawing drawing_of(const SceneConfig& scene);

/// Returns the simplest solid of uniform density with this mass and inertia: a sphere, a cylinder or a box.
Solid solid_of_inertia(double mass, const Mat3& inertia);

}  // namespace godobject
