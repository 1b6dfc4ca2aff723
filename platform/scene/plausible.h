// Checks of units and sizes far outside the range of a hand. Each function returns an empty text or a
// warning: the quantity with its unit, the bounds, and the remedy.
#pragma once

#include <string>

#include "platform/scene/scene.h"

namespace godobject {

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

}  // namespace godobject
