// Shapes that touch others by the spheres of their body alone: narrower solids pass between these at any speed.
//
// A shape is touched by spheres and nodes of nets; boxes of two bodies also touch at their edges. No two shapes
// are compared otherwise (core/contact/find/find.h). So a body that has shapes misses
//
//   obstacles, other than planes, unless one of its spheres holds the shape;
//   planes, unless a sphere is set at each corner and end of the shape;
//   shapes of other bodies, unless a sphere holds one of the two, or both are boxes with all corners held.
#pragma once

#include <string>
#include <vector>

#include "platform/scene/scene.h"

namespace godobject {

/// How much of its shapes the spheres of a body stand for.
enum class ShapeCover : std::uint8_t {
  none,
  tips,   // a sphere is set at each corner of a box and each end of a capsule
  whole,  // each shape is within a sphere, or there are no shapes
};

ShapeCover shape_cover(const BodyConfig& body);

/// True if a body's shapes meet an obstacle of this kind wherever they come to it.
bool meets_obstacle(ShapeCover cover, ShapeKind obstacle);

/// True if two bodies that may touch meet each other wherever they come together.
bool meet_each_other(const BodyConfig& a, const BodyConfig& b);

/// Bodies whose shapes meet others by spheres alone, each with the first of the others.
struct SpheresAlone {
  std::string body, other;     // names: "tray", "obstacle 'post'"
  std::size_t num_others = 0;  // that it meets so
};
std::vector<SpheresAlone> spheres_alone(const SceneConfig& scene);

/// Spheres whose centres begin within a solid that they are to touch.
struct BuriedSpheres {
  std::size_t num = 0;
  std::string deepest;  // "sphere of body 'tool' in obstacle 'wall'"
  double depth = 0;     // of the deepest, from its lowest point to the surface, m
};
BuriedSpheres buried_spheres(const SceneConfig& scene);

}  // namespace godobject
