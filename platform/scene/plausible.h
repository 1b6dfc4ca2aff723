// Units and sizes that a scene cannot mean: far outside anything that a hand works with. Each function returns an empty
// text, or a warning's: the quantity with its unit, the bounds, and the remedy.
#pragma once

#include <string>

#include "platform/scene/scene.h"

namespace godobject {

/// Radius of gyration against the reach of spheres and shapes. All mass within the reach R has r_g <= R, a homogeneous
/// sphere 0.63 R; parts that touch nothing may reach farther than what touches.
inline constexpr double min_gyration = 0.1, max_gyration = 5;      // of R
inline constexpr double min_density = 1, max_density = 30'000;     // kg/m^3
inline constexpr double max_surface_density = 100;                 // kg/m^2
inline constexpr double min_mesh_size = 1e-4, max_mesh_size = 10;  // m, the longest side of its bounding box
inline constexpr double max_hand_speed = 5;                        // m/s

std::string doubt_of_gyration(const BodyConfig& body);
/// The volume is the larger one of shapes and of the bounding box of spheres. Where there are no shapes, or mass is beyond
/// them, it may be as small as the homogeneous ellipsoid with the body's mass and inertia and as large as a ball of its
/// radius of gyration.
std::string doubt_of_density(const BodyConfig& body);
/// thickness: of the net, m; 0: not compared.
std::string doubt_of_density(double surface_density, double thickness);
/// mesh: in m, its file's scale applied; owner: "obstacle 'liver'".
std::string doubt_of_size(const MeshData& mesh, const std::string& owner);

}  // namespace godobject
