// Surfaces of nets: vertices and triangles with edges of nearly the requested length.
#pragma once

#include "platform/scene/net/config.h"

namespace godobject {

/// Returns the number of vertices that generated_surface() will make, within a factor of two.
double expected_vertices(const NetConfig& net);

/// Generates a surface by kind and dimensions, which must be set; not for meshes.
MeshData generated_surface(const NetConfig& net);

/// Returns the surface with its vertices sorted along its longest extent, z if tied. Springs then join near
/// numbers only, by which incomplete factors lose least.
MeshData ordered_along(const MeshData& surface);

}  // namespace godobject
