// Solids as triangles, for pictures that are drawn without a browser.
#pragma once

#include <array>
#include <vector>

#include "platform/view/solids.h"

namespace godobject {

using Colour = std::array<std::uint8_t, 3>;

/// Returns triangles in the axes of the solid. plane_half_size: half size of the square that represents a
/// plane, m.
MeshData triangles_of(const Solid& solid, const Drawing& drawing, double plane_half_size);
/// Returns the wireframe of a solid: pairs of points, in the axes of the solid.
std::vector<std::array<Vec3, 2>> wires_of(const Solid& solid, const Drawing& drawing);

/// Returns a cylinder from a to b.
MeshData rod(const Vec3& a, const Vec3& b, double radius);
/// Returns an arrow from a to b. shaft_radius: radius of its shaft, m.
MeshData arrow(const Vec3& a, const Vec3& b, double shaft_radius);

}  // namespace godobject
