// Surfaces of nets: nearly equal edges, areas, closed or open, in order; errors of invalid ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "platform/scene/net/params.h"

namespace godobject::test_net_surface {
namespace {

using std::numbers::pi;
using testing::HasSubstr;
using testing::IsEmpty;

struct Drawn {
  NetConfig net;
  double area;  // of the smooth surface, m^2
};

/// Returns a random surface of 2 cm to 30 cm, with a spacing of an eighth to a third of the smallest size.
Drawn drawn(NetKind kind, std::mt19937& random) {
  std::uniform_real_distribution<double> size(0.02, 0.15), part(0.125, 0.33);
  Drawn d;
  d.net.kind = kind;
  const double r = size(random), l = size(random), w = size(random);
  d.net.spacing = part(random) * std::min({r, l, w});
  if (kind == NetKind::sheet) {
    d.net.length = 2 * l;
    d.net.width = 2 * w;
    d.area = 4 * l * w;
    return d;
  }
  d.net.radius = r;
  d.area = 4 * pi * r * r;
  if (kind == NetKind::sphere) return d;
  d.net.half_length = l;
  d.area = 4 * pi * r * l + (kind == NetKind::capsule ? 4 * pi * r * r : 0);
  return d;
}

const std::vector kinds{NetKind::tube, NetKind::capsule, NetKind::sphere, NetKind::sheet};

template <class Check>
void each_drawn(const Check& check) {
  std::mt19937 random(20261124);
  for (int trial = 0; trial < 50; ++trial)
    for (const NetKind kind : kinds) {
      const Drawn d = drawn(kind, random);
      SCOPED_TRACE(std::string(net_kind_names[static_cast<std::size_t>(kind)]) + " of trial " +
                   std::to_string(trial));
      check(d, generated_surface(d.net));
    }
}

TEST(NetSurface, EdgesAreNearlyAsLongAsSpecified) {
  each_drawn([](const Drawn& d, const MeshData& surface) {
    for (const SurfaceEdge& e : edges_of(surface)) {
      EXPECT_GT(e.length, 0.75 * *d.net.spacing);
      EXPECT_LT(e.length, 1.4 * *d.net.spacing);
    }
    EXPECT_NEAR(mean_edge_of(surface) / *d.net.spacing, 1, 0.1);
  });
}

TEST(NetSurface, AreasAreThoseOfTheSmoothSurface) {
  each_drawn([](const Drawn& d, const MeshData& surface) {
    const double error = area_of(surface) / d.area - 1;
    if (d.net.kind == NetKind::sheet) {
      EXPECT_NEAR(error, 0, 1e-12);
      return;
    }
    // Chords of length s instead of arcs of radius r shorten a length by the factor s^2 / (24 r^2).
    const double s_r = *d.net.spacing / *d.net.radius;
    EXPECT_LT(error, 1e-12);
    EXPECT_GT(error, -0.25 * s_r * s_r);
  });
}

TEST(NetSurface, IsClosedOrHasTheRimsItShould) {
  each_drawn([](const Drawn& d, const MeshData& surface) {
    EXPECT_THAT(why_no_net(surface), IsEmpty());
    const std::vector<SurfaceEdge> edges = edges_of(surface);
    const auto euler = static_cast<long>(surface.vertices.size()) - static_cast<long>(edges.size()) +
                       static_cast<long>(surface.triangles.size());
    const long expected = d.net.kind == NetKind::tube ? 0 : d.net.kind == NetKind::sheet ? 1 : 2;
    EXPECT_EQ(euler, expected);
    const bool closed = d.net.kind == NetKind::capsule || d.net.kind == NetKind::sphere;
    EXPECT_EQ(std::ranges::none_of(edges, [](const SurfaceEdge& e) { return e.num_triangles == 1; }), closed);
  });
}

TEST(NetSurface, TrianglesFaceOutwards) {
  each_drawn([](const Drawn& d, const MeshData& surface) {
    for (const TriangleIndices& t : surface.triangles) {
      const Vec3 &a = surface.vertices[t[0]], &b = surface.vertices[t[1]], &c = surface.vertices[t[2]];
      Vec3 out = (a + b + c) / 3;
      if (d.net.kind == NetKind::sheet) out = Vec3::UnitZ();
      if (d.net.kind == NetKind::tube) out.z() = 0;
      if (d.net.kind == NetKind::capsule)
        out.z() -= std::clamp(out.z(), -*d.net.half_length, *d.net.half_length);
      EXPECT_GT((b - a).cross(c - a).dot(out), 0);
    }
  });
}

TEST(NetSurface, VerticesAreOnTheShape) {
  each_drawn([](const Drawn& d, const MeshData& surface) {
    for (const Vec3& p : surface.vertices) {
      if (d.net.kind == NetKind::sheet) {
        EXPECT_EQ(p.z(), 0);
        continue;
      }
      const double l = d.net.half_length.value_or(0);
      EXPECT_NEAR((p - Vec3(0, 0, std::clamp(p.z(), -l, l))).norm(), *d.net.radius, 1e-12);
    }
  });
}

/// Returns the largest difference of the numbers of two neighbours.
std::uint32_t bandwidth(const MeshData& surface) {
  std::uint32_t widest = 0;
  for (const SurfaceEdge& e : edges_of(surface)) widest = std::max(widest, e.j - e.i);
  return widest;
}

TEST(NetSurface, NumbersOfNeighboursAreNearWhateverTheFile) {
  std::mt19937 random(7);
  each_drawn([&](const Drawn& d, const MeshData& surface) {
    // Vertices in any order, as in a mesh file, along x.
    std::vector<std::uint32_t> place(surface.vertices.size());
    for (std::uint32_t i = 0; i < place.size(); ++i) place[i] = i;
    std::ranges::shuffle(place, random);
    MeshData shuffled;
    shuffled.vertices.resize(place.size());
    for (std::size_t i = 0; i < place.size(); ++i) {
      const Vec3& p = surface.vertices[i];
      shuffled.vertices[place[i]] = Vec3(p.z(), p.x(), p.y());
    }
    for (const TriangleIndices& t : surface.triangles)
      shuffled.triangles.push_back({place[t[0]], place[t[1]], place[t[2]]});
    const MeshData ordered = ordered_along(shuffled);
    EXPECT_NEAR(area_of(ordered), area_of(surface), 1e-12);
    EXPECT_EQ(edges_of(ordered).size(), edges_of(surface).size());
    const double across = std::sqrt(d.area) / *d.net.spacing;  // of a square of the same area
    EXPECT_LT(bandwidth(ordered), 4 * across + 8);
  });
}

TEST(NetSurface, AreasOfVerticesAddUp) {
  each_drawn([](const Drawn&, const MeshData& surface) {
    double sum = 0;
    for (const double a : vertex_areas(surface)) sum += a;
    EXPECT_NEAR(sum, area_of(surface), 1e-12);
  });
}

TEST(NetSurface, SpacingThatFitsIsReported) {
  for (const double spacing : {1e-3, 1e-7, 1e-100, 1e-320}) {
    NetConfig net;
    net.kind = NetKind::capsule;
    net.radius = 0.03;
    net.half_length = 0.05;
    net.spacing = spacing;
    const std::string why_not = make_surface("", max_net_nodes, net);
    EXPECT_THAT(why_not, HasSubstr("above the capacity of 1536"));
    if (spacing < 1e-50) continue;
    const std::size_t at = why_not.find("a spacing of ");
    ASSERT_NE(at, std::string::npos);
    net.spacing = std::stod(why_not.substr(at + 13));
    EXPECT_LT(*net.spacing, 0.01);
    ASSERT_THAT(make_surface("", max_net_nodes, net), IsEmpty());
    EXPECT_GT(net.surface.vertices.size(), max_net_nodes / 2);
  }
}

TEST(NetSurface, ExpectedVerticesAreWithinAFactorOfTwo) {
  each_drawn([](const Drawn& d, const MeshData& surface) {
    const auto n = static_cast<double>(surface.vertices.size());
    EXPECT_LT(expected_vertices(d.net), 2 * n);
    EXPECT_GT(expected_vertices(d.net), n / 2);
  });
}

/// Returns a square of two triangles.
MeshData square() {
  return {{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)}, {{0, 1, 2}, {0, 2, 3}}};
}

TEST(NetSurface, WhatIsNoneIsRefusedWithItsPlace) {
  EXPECT_THAT(why_no_net(square()), IsEmpty());
  EXPECT_THAT(why_no_net({}), HasSubstr("has no triangles: export the surface as triangles"));

  MeshData flat = square();
  flat.vertices[3] = Vec3(0.5, 0.5, 0);
  EXPECT_THAT(why_no_net(flat), HasSubstr("triangle 2 at (0.0, 0.0, 0.0) has almost no area"));

  MeshData three = square();
  three.vertices.emplace_back(0.5, 0.5, 1);
  three.triangles.push_back({0, 2, 4});
  EXPECT_THAT(why_no_net(three),
              HasSubstr("3 triangles meet at the edge from (0.0, 0.0, 0.0) to (1.0, 1.0, 0.0)"));

  MeshData twice = square();
  twice.triangles = {{0, 1, 2}, {1, 0, 2}};
  EXPECT_THAT(why_no_net(twice), HasSubstr("two triangles at (0.0, 0.0, 0.0) have the same corners"));

  MeshData seam = square();
  seam.vertices.emplace_back(1.001, 1, 0);
  seam.vertices.emplace_back(2, 0, 0);
  seam.triangles.push_back({1, 5, 4});
  EXPECT_THAT(why_no_net(seam), HasSubstr("less than a hundredth of the mean edge: weld them"));
}

}  // namespace
}  // namespace godobject::test_net_surface
