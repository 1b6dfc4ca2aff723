#include "platform/scene/net/edges.h"

#include <algorithm>
#include <map>
#include <utility>

#include "platform/scene/text/key.h"

namespace godobject {
namespace {

double area(const MeshData& surface, const TriangleIndices& t) {
  const Vec3 &a = surface.vertices[t[0]], &b = surface.vertices[t[1]], &c = surface.vertices[t[2]];
  return (b - a).cross(c - a).norm() / 2;
}

std::string at(const Vec3& p) {
  return "(" + shortest(p.x()) + ", " + shortest(p.y()) + ", " + shortest(p.z()) + ")";
}

/// Approximate lower bound of a triangle's angles, rad.
constexpr double least_slimness = 1e-3;

std::string why_no_triangle(const MeshData& surface) {
  for (std::size_t n = 0; n < surface.triangles.size(); ++n) {
    const TriangleIndices& t = surface.triangles[n];
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k)
      longest = std::max(longest, (surface.vertices[t[k]] - surface.vertices[t[(k + 1) % 3]]).norm());
    if (!(area(surface, t) > least_slimness / 2 * longest * longest))
      return "triangle " + std::to_string(n + 1) + " at " + at(surface.vertices[t[0]]) +
             " has almost no area: remesh the surface with edges of equal length";
  }
  return "";
}

std::string why_no_edge(const MeshData& surface) {
  for (const SurfaceEdge& e : edges_of(surface)) {
    if (e.num_triangles > 2)
      return std::to_string(e.num_triangles) + " triangles meet at the edge from " +
             at(surface.vertices[e.i]) + " to " + at(surface.vertices[e.j]) +
             ", but a net has at most two triangles at an edge; cut the surface there";
    if (e.num_triangles == 2 && e.opposite[0] == e.opposite[1])
      return "two triangles at " + at(surface.vertices[e.i]) + " have the same corners: remove one of them";
  }
  return "";
}

/// Rejects vertices that nearly coincide, since such seams would separate.
std::string why_no_vertex(const MeshData& surface) {
  constexpr double near = 0.01;  // relative to the mean edge
  const double least = near * mean_edge_of(surface);
  const std::vector<Vec3>& p = surface.vertices;
  std::vector<std::size_t> order(p.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::sort(order, {}, [&](std::size_t i) { return p[i].x(); });
  for (std::size_t a = 0; a < order.size(); ++a)
    for (std::size_t b = a + 1; b < order.size() && p[order[b]].x() - p[order[a]].x() < least; ++b)
      if ((p[order[b]] - p[order[a]]).norm() < least)
        return "two vertices at " + at(p[order[a]]) + " are " + shortest((p[order[b]] - p[order[a]]).norm()) +
               " m apart, less than a hundredth of the mean edge: weld them";
  return "";
}

}  // namespace

std::vector<SurfaceEdge> edges_of(const MeshData& surface) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, SurfaceEdge> edges;
  for (const TriangleIndices& t : surface.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [i, j] = std::minmax(t[k], t[(k + 1) % 3]);
      SurfaceEdge& e = edges[{i, j}];
      e.i = i;
      e.j = j;
      e.length = (surface.vertices[j] - surface.vertices[i]).norm();
      e.area += area(surface, t);
      if (e.num_triangles < 2) e.opposite[static_cast<std::size_t>(e.num_triangles)] = t[(k + 2) % 3];
      ++e.num_triangles;
    }
  }
  std::vector<SurfaceEdge> list;
  for (const auto& [ends, edge] : edges) list.push_back(edge);
  return list;
}

double area_of(const MeshData& surface) {
  double sum = 0;
  for (const TriangleIndices& t : surface.triangles) sum += area(surface, t);
  return sum;
}

double mean_edge_of(const MeshData& surface) {
  const std::vector<SurfaceEdge> edges = edges_of(surface);
  double sum = 0;
  for (const SurfaceEdge& e : edges) sum += e.length;
  return edges.empty() ? 0 : sum / static_cast<double>(edges.size());
}

std::vector<double> vertex_areas(const MeshData& surface) {
  std::vector<double> areas(surface.vertices.size());
  for (const TriangleIndices& t : surface.triangles)
    for (const std::uint32_t v : t) areas[v] += area(surface, t) / 3;
  return areas;
}

std::vector<bool> rim_of(const MeshData& surface) {
  std::vector<bool> rim(surface.vertices.size());
  for (const SurfaceEdge& e : edges_of(surface))
    if (e.num_triangles == 1) rim[e.i] = rim[e.j] = true;
  return rim;
}

std::string why_no_net(const MeshData& surface) {
  if (surface.triangles.empty()) return "has no triangles: export the surface as triangles";
  for (const auto& rule : {why_no_triangle, why_no_edge, why_no_vertex})
    if (std::string why_not = rule(surface); !why_not.empty()) return why_not;
  return "";
}

}  // namespace godobject
