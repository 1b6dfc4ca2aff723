#include "platform/scene/net/params.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "core/math/so3.h"
#include "platform/scene/text/key.h"

namespace godobject {
namespace {

const double row_height = std::sqrt(3.0) / 2;  // height of an equilateral triangle of side 1

/// Returns the number of steps of about `step` in `length`, at least `least`.
int steps_in(double length, double step, int least) {
  return std::max(least, static_cast<int>(std::lround(length / step)));
}

std::uint32_t number(const MeshData& surface) { return static_cast<std::uint32_t>(surface.vertices.size()); }

/// Vertices on a circle about z.
/// turn: angle of the first one, in steps.
struct Ring {
  std::uint32_t first = 0;
  int count = 1;  // 1: a pole
  double turn = 0;

  std::uint32_t vertex(int i) const { return first + static_cast<std::uint32_t>(i % count); }
  double angle(int i) const { return 2 * pi * (i + turn) / count; }
};

Ring add_ring(MeshData& to, double r, double z, int count, double turn) {
  const Ring ring{number(to), count, turn};
  for (int i = 0; i < count; ++i)
    to.vertices.emplace_back(r * std::cos(ring.angle(i)), r * std::sin(ring.angle(i)), z);
  return ring;
}

/// Adds triangles between two rings, `above` after `below` along z, outside to the right. Each step advances
/// on the ring whose next vertex makes the shorter edge across.
void add_strip(MeshData& to, const Ring& below, const Ring& above) {
  if (below.count == 1) {
    for (int j = 0; j < above.count; ++j)
      to.triangles.push_back({below.first, above.vertex(j + 1), above.vertex(j)});
    return;
  }
  if (above.count == 1) {
    for (int i = 0; i < below.count; ++i)
      to.triangles.push_back({below.vertex(i), below.vertex(i + 1), above.first});
    return;
  }
  // The first edge across connects the first vertex below and the nearest one above.
  int start = 0;
  for (int j = -above.count; j < above.count; ++j)
    if (std::abs(above.angle(j) - below.angle(0)) < std::abs(above.angle(start) - below.angle(0))) start = j;
  const auto vertex_above = [&](int j) { return above.vertex((j + start + 2 * above.count) % above.count); };
  const auto place = [&](std::uint32_t v) -> const Vec3& { return to.vertices[v]; };
  for (int i = 0, j = 0; i < below.count || j < above.count;) {
    const std::uint32_t a = below.vertex(i), a_next = below.vertex(i + 1), b = vertex_above(j),
                        b_next = vertex_above(j + 1);
    const bool along_below = j == above.count || (i < below.count && (place(a_next) - place(b)).norm() <=
                                                                         (place(b_next) - place(a)).norm());
    if (along_below) {
      to.triangles.push_back({a, a_next, b});
      ++i;
    } else {
      to.triangles.push_back({a, b_next, b});
      ++j;
    }
  }
}

/// Makes a surface of revolution about z.
/// s: arc length along its profile from the lower end, m.
template <class Profile>
MeshData revolved(const Profile& profile, double arc, double spacing, bool closed) {
  MeshData surface;
  const int rows = steps_in(arc, row_height * spacing, closed ? 2 : 1);
  Ring below;
  for (int i = 0; i <= rows; ++i) {
    const Eigen::Vector2d rz = profile(arc * i / rows);
    const bool pole = closed && (i == 0 || i == rows);
    const int count = pole ? 1 : steps_in(2 * pi * rz.x(), spacing, 3);
    const Ring ring = add_ring(surface, pole ? 0 : rz.x(), rz.y(), count, i % 2 == 0 ? 0 : 0.5);
    if (i > 0) add_strip(surface, below, ring);
    below = ring;
  }
  return surface;
}

MeshData tube(double radius, double half_length, double spacing) {
  return revolved([&](double s) { return Eigen::Vector2d(radius, s - half_length); }, 2 * half_length,
                  spacing, false);
}

/// Makes a capsule; a sphere if half_length is zero.
MeshData capsule(double radius, double half_length, double spacing) {
  const double cap = pi / 2 * radius;
  const auto profile = [&](double s) -> Eigen::Vector2d {
    const double along = std::clamp(s - cap, 0.0, 2 * half_length);  // on the cylinder
    const double angle = (s - along) / radius;                       // on the caps, from the lower pole
    return {radius * std::sin(angle), along - half_length - radius * std::cos(angle)};
  };
  return revolved(profile, 2 * cap + 2 * half_length, spacing, true);
}

/// Makes rows along x, every other one shifted by half a step. The side edges zigzag by a quarter step about
/// those of the rectangle. So all edges have one length, and the area is that of the rectangle.
MeshData sheet(double length, double width, double spacing) {
  MeshData surface;
  const int steps = steps_in(length, spacing, 1), rows = steps_in(width, row_height * spacing, 1);
  const double dx = length / steps;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= steps; ++i)
      surface.vertices.emplace_back(dx * (i + (j % 2 == 0 ? -0.25 : 0.25)) - length / 2,
                                    width * j / rows - width / 2, 0);
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(j * (steps + 1) + i); };
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < steps; ++i) {
      const std::uint32_t a = at(i, j), b = at(i + 1, j), c = at(i, j + 1), d = at(i + 1, j + 1);
      if (j % 2 == 0) surface.triangles.insert(surface.triangles.end(), {{a, b, c}, {b, d, c}});
      else surface.triangles.insert(surface.triangles.end(), {{a, b, d}, {a, d, c}});
    }
  }
  return surface;
}

/// Returns 0 to 2; z unless the surface is clearly longer along another axis.
Eigen::Index longest_axis(const MeshData& surface) {
  Vec3 low = surface.vertices.front(), high = low;
  for (const Vec3& p : surface.vertices) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  constexpr double clearly = 1.01;
  const Vec3 extent = high - low;
  Eigen::Index axis = 0;
  extent.maxCoeff(&axis);
  return extent[axis] < clearly * extent.z() ? 2 : axis;
}

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

// ---- surfaces -------------------------------------------------------------------------------------

double expected_vertices(const NetConfig& net) {
  const double spacing = net.spacing.value_or(0), r = net.radius.value_or(0) / spacing,
               l = 2 * net.half_length.value_or(0) / spacing;
  const auto revolved = [&](double arc, double area) { return std::max(area, 3 * arc) / row_height; };
  switch (net.kind) {
    case NetKind::tube: return std::max(3.0, 2 * pi * r) * (1 + l / row_height);
    case NetKind::capsule: return revolved(l + pi * r, 2 * pi * r * (l + 2 * r));
    case NetKind::sphere: return revolved(pi * r, 4 * pi * r * r);
    case NetKind::sheet: return (1 + *net.length / spacing) * (1 + *net.width / spacing / row_height);
    case NetKind::mesh: break;
  }
  return 0;
}

MeshData generated_surface(const NetConfig& net) {
  const double spacing = net.spacing.value_or(0);
  switch (net.kind) {
    case NetKind::tube: return tube(*net.radius, *net.half_length, spacing);
    case NetKind::capsule: return capsule(*net.radius, *net.half_length, spacing);
    case NetKind::sphere: return capsule(*net.radius, 0, spacing);
    case NetKind::sheet: return sheet(*net.length, *net.width, spacing);
    case NetKind::mesh: break;
  }
  return {};
}

MeshData ordered_along(const MeshData& surface) {
  if (surface.vertices.empty()) return surface;
  const Eigen::Index axis = longest_axis(surface);
  std::vector<std::uint32_t> order(surface.vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t v) { return surface.vertices[v][axis]; });
  std::vector<std::uint32_t> place(order.size());
  MeshData ordered;
  for (const std::uint32_t v : order) {
    place[v] = number(ordered);
    ordered.vertices.push_back(surface.vertices[v]);
  }
  for (const TriangleIndices& t : surface.triangles)
    ordered.triangles.push_back({place[t[0]], place[t[1]], place[t[2]]});
  return ordered;
}

// ---- edges ----------------------------------------------------------------------------------------

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
