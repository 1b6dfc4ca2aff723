// Checks of a scene beyond the ranges of its keys: implausible units and sizes, shapes that touch by spheres
// alone, and top speeds.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "platform/scene/scene.h"

namespace godobject {

// Units and sizes far outside the range of a hand. Each function returns an empty text or a warning: the
// quantity with its unit, the bounds, and the remedy.

/// Compares the radius of gyration with the reach R of spheres and shapes. Mass within R has r_g <= R, a
/// homogeneous sphere 0.63 R. Parts without contacts may reach farther.
inline constexpr double min_gyration = 0.1, max_gyration = 5;      // relative to R
inline constexpr double min_density = 1, max_density = 30'000;     // kg/m^3
inline constexpr double max_surface_density = 100;                 // kg/m^2
inline constexpr double min_mesh_size = 1e-4, max_mesh_size = 10;  // m, longest side of the bounding box
inline constexpr double max_hand_speed = 5;                        // m/s

std::string doubt_of_gyration(const BodyConfig& body);
/// Estimates the volume as the larger one of the shapes and of the spheres' bounding box. Without shapes, or
/// with mass beyond them, the volume has bounds. They are the homogeneous ellipsoid of the body's mass and
/// inertia, and the ball of its radius of gyration.
std::string doubt_of_density(const BodyConfig& body);
/// thickness: thickness of the net, m; 0: not checked.
std::string doubt_of_density(double surface_density, double thickness);
/// mesh: in m, with the file's scale applied; owner: "obstacle 'liver'".
std::string doubt_of_size(const MeshData& mesh, const std::string& owner);

// Shapes that touch meshes and height fields only with their corners and ends, and the spheres of their body.
// Narrower parts of a mesh pass between these at any speed.
//
// Balls, capsules and boxes meet each other and planes at every place (core/contact/find/find.h).

/// True if a body touches an obstacle of this kind at every place of its shapes. A mesh or height field it
/// so touches if each shape is a ball or within a sphere of the body.
bool meets_obstacle(const BodyConfig& body, ShapeKind obstacle);

/// A body whose shapes touch meshes only with corners, ends and spheres, and the first of the meshes.
struct SpheresAlone {
  std::string body, other;     // names: "tray", "obstacle 'liver'"
  std::size_t num_others = 0;  // number of the others
};
std::vector<SpheresAlone> spheres_alone(const SceneConfig& scene);

/// Spheres and shapes of bodies that start deep inside a solid that they can touch. The centre of a sphere is
/// inside, or that of a largest ball in the middle, a corner or an end of a shape.
struct BuriedSolids {
  std::size_t num = 0;
  std::string deepest;  // "sphere of body 'tool' in obstacle 'wall'"
  double depth = 0;     // m, from the lowest point of the deepest sphere or ball to the surface
};
BuriedSolids buried_solids(const SceneConfig& scene);

// Speeds up to which the contacts of a scene let nothing pass, derived in top_speed.cc.

/// Speeds up to which a sphere and its opposite solid, or two boxes, hold. Infinite without a bound.
struct SpeedBound {
  std::string what;   // "sphere of body 'tool' and obstacle 'wall'", "boxes of bodies 'a' and 'b'"
  double travel = 0;  // m/s
  double energy = 0;  // m/s
  double hand = 0;    // x_H, m
  double top() const { return travel < energy ? travel : energy; }
};

/// Returns the bound of the pair with the lowest top speed; none without contacts, or if there is no bound.
std::optional<SpeedBound> top_speed(const SceneConfig& scene);

/// Returns the subject of "... passes through a solid", with the nets and shapes that the bound excludes.
const char* what_does_not_pass(const SceneConfig& scene);

/// Returns the bound as a line: "1.5 m/s: up to this speed nothing passes through a solid, ...", or that it
/// is infinite or missing. Empty if nothing can touch.
std::string top_speed_text(const SceneConfig& scene);

/// Returns the shortest distance through the solid along inward normals, sampled at up to 2000 triangles, m.
double thinnest(const MeshData& mesh);

inline constexpr double advised_top_speed = 2;  // m/s, speed of a fast hand

}  // namespace godobject
