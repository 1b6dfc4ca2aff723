// Mesh edges of a net's surface: lengths, areas, and validity checks.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "platform/scene/contact/config.h"

namespace godobject {

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
