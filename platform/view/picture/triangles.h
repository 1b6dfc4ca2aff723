// Solids as triangles, for pictures that are drawn without a browser.
#pragma once

#include <array>
#include <vector>

#include "platform/view/solids.h"

namespace godobject {

using Colour = std::array<std::uint8_t, 3>;

/// In the axes of the solid; a plane is a square of this half size, m.
MeshData triangles_of(const Solid& solid, const Drawing& drawing, double plane_half_size);
/// The edges of a solid that are drawn of a wireframe: pairs of points, in the axes of the solid.
std::vector<std::array<Vec3, 2>> wires_of(const Solid& solid, const Drawing& drawing);

/// A cylinder from a to b.
MeshData rod(const Vec3& a, const Vec3& b, double radius);
/// An arrow from a to b; shaft_radius: of its shaft.
MeshData arrow(const Vec3& a, const Vec3& b, double shaft_radius);

}  // namespace godobject
