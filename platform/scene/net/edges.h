// Edges of a net's surface, what they say of it, and why a surface is none for a net.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "platform/scene/contact/config.h"

namespace godobject {

/// An edge, i < j, and the one or two triangles on it.
struct SurfaceEdge {
  std::uint32_t i = 0, j = 0;
  double length = 0;                        // m
  double area = 0;                          // of its triangles, m^2
  int num_triangles = 0;                    // 1: it is on the rim
  std::array<std::uint32_t, 2> opposite{};  // the third corner of each
};

/// In the order of i, then j.
std::vector<SurfaceEdge> edges_of(const MeshData& surface);

double area_of(const MeshData& surface);       // m^2
double mean_edge_of(const MeshData& surface);  // m
/// The area of each vertex, a third of its triangles', m^2.
std::vector<double> vertex_areas(const MeshData& surface);
/// For each vertex whether it is on the edge of the surface.
std::vector<bool> rim_of(const MeshData& surface);

/// Empty, or what keeps the surface from being a net's, and what to do.
std::string why_no_net(const MeshData& surface);

}  // namespace godobject
