// Surfaces of nets: vertices and triangles with edges of nearly the requested length, and the lengths, areas
// and validity of their edges.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "platform/scene/geometry.h"

namespace godobject {

/// Returns the number of vertices that generated_surface() will make, within a factor of two.
double expected_vertices(const NetConfig& net);

/// Generates a surface by kind and dimensions, which must be set; not for meshes.
MeshData generated_surface(const NetConfig& net);

/// Returns the surface with its vertices sorted along its longest extent, z if tied. Springs then join near
/// numbers only, by which incomplete factors lose least.
MeshData ordered_along(const MeshData& surface);

/// An edge, i < j, and its one or two triangles.
struct SurfaceEdge {
  std::uint32_t i = 0, j = 0;
  double length = 0;                        // m
  double area = 0;                          // m^2, of its triangles
  int num_triangles = 0;                    // 1: on the rim
  std::array<std::uint32_t, 2> opposite{};  // third corner of each triangle
};

/// Returns the edges in the order of i, then j.
std::vector<SurfaceEdge> edges_of(const MeshData& surface);

double area_of(const MeshData& surface);       // m^2
double mean_edge_of(const MeshData& surface);  // m
/// Returns the area of each vertex, a third of its triangles', m^2.
std::vector<double> vertex_areas(const MeshData& surface);
/// Returns for each vertex true if it is on the edge of the surface.
std::vector<bool> rim_of(const MeshData& surface);

/// Returns why the surface is not valid for a net, with the remedy; empty if it is.
std::string why_no_net(const MeshData& surface);

}  // namespace godobject
