// Surfaces of nets: vertices and triangles whose edges have nearly the length that is asked for.
#pragma once

#include "platform/scene/net/config.h"

namespace godobject {

/// Vertices of what is generated for the net, before it is, within a factor of two.
double expected_vertices(const NetConfig& net);

/// A surface by its kind and dimensions, which are there; not for meshes.
MeshData generated_surface(const NetConfig& net);

/// The same surface, its vertices in the order of their place along its longest extent (that of z where it is one of
/// them): springs then join near numbers only, which is what incomplete factors lose least by.
MeshData ordered_along(const MeshData& surface);

}  // namespace godobject
