// Shapes that touch others only with the spheres of their body, so that narrower solids pass between these at
// any speed.
//
// A shape is touched by spheres and nodes of nets. Boxes of two bodies also touch at their edges. No other
// shapes are compared (core/contact/find/find.h). So a body with shapes misses
//
//   obstacles other than planes, unless one of its spheres contains the shape;
//   planes, unless a sphere is set at each corner and end of the shape;
//   shapes of other bodies, unless a sphere contains one of the two, or both are boxes with all corners
//   covered.
#pragma once

#include <string>
#include <vector>

#include "platform/scene/scene.h"

namespace godobject {

/// Cover of a body's shapes by its spheres.
enum class ShapeCover : std::uint8_t {
  none,
  tips,   // a sphere is set at each corner of a box and each end of a capsule
  whole,  // each shape is within a sphere, or there are no shapes
};

ShapeCover shape_cover(const BodyConfig& body);

/// True if a body with this cover touches an obstacle of this kind at every place of its shapes.
bool meets_obstacle(ShapeCover cover, ShapeKind obstacle);

/// True if two bodies that may touch do so at every place of their shapes.
bool meet_each_other(const BodyConfig& a, const BodyConfig& b);

/// A body whose shapes touch others only with spheres, and the first of the others.
struct SpheresAlone {
  std::string body, other;     // names: "tray", "obstacle 'post'"
  std::size_t num_others = 0;  // number of the others
};
std::vector<SpheresAlone> spheres_alone(const SceneConfig& scene);

/// Spheres whose centres start inside a solid that they can touch.
struct BuriedSpheres {
  std::size_t num = 0;
  std::string deepest;  // "sphere of body 'tool' in obstacle 'wall'"
  double depth = 0;     // m, from the lowest point of the deepest sphere to the surface
};
BuriedSpheres buried_spheres(const SceneConfig& scene);

}  // namespace godobject
