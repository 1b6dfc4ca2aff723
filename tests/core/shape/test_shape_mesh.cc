#include <map>
#include <utility>

#include "tests/core/mesh_arrays.h"
#include "tests/core/shape_checks.h"

namespace godobject::test_shape_mesh {
namespace {

/// The most triangles a query within `reach` (m) looks at; one in several cells counts in each.
Real max_visits(const MeshGrid& grid, Real reach) {
  Real visits = 0;  // in the fullest cell
  for (std::size_t c = 0; c + 1 < grid.start.size(); ++c)
    visits = std::max(visits, Real(grid.start[c + 1] - grid.start[c]));
  for (const std::uint32_t num : grid.num) visits *= std::min(2 * reach / grid.spacing + 2, Real(num));
  return visits;
}

struct Solid : MeshArrays {
  ShapeParams params(const Pose& X_WS = {}) const {
    return {.kind = ShapeKind::mesh, .X_WS = X_WS, .mesh = &mesh};
  }
};

Solid box_mesh(const Vec3& b) {
  Solid s;
  for (int v = 0; v < 8; ++v)
    s.vertices.push_back(b.cwiseProduct(Vec3(v & 1 ? 1 : -1, v & 2 ? 1 : -1, v & 4 ? 1 : -1)));
  s.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return s;
}

/// Octahedron whose triangles are split in four a number of times; vertices on the unit sphere.
Solid sphere_mesh(int splits) {
  Solid s;
  s.vertices = {Vec3::UnitX(), -Vec3::UnitX(), Vec3::UnitY(), -Vec3::UnitY(), Vec3::UnitZ(), -Vec3::UnitZ()};
  s.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int i = 0; i < splits; ++i) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), std::uint32_t(s.vertices.size()));
      if (is_new) s.vertices.push_back((s.vertices[a] + s.vertices[b]).normalized());
      return at->second;
    };
    std::vector<TriangleIndices> split;
    for (const auto& [a, b, c] : s.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      split.insert(split.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    s.triangles = split;
  }
  return s;
}

/// A sphere with every vertex moved along its radius: sharp peaks, valleys and saddles.
Solid spiky_mesh() {
  Solid s = sphere_mesh(2);
  Random random(8);
  for (Vec3& v : s.vertices) v *= random.uniform(0.4, 1);
  return s;
}

/// Radii 0.7 and 0.25 m.
Solid torus_mesh() {
  Solid s;
  const std::uint32_t n = 16, m = 10;
  for (std::uint32_t i = 0; i < n; ++i) {
    for (std::uint32_t j = 0; j < m; ++j) {
      const Real a = 2 * pi * i / n, b = 2 * pi * j / m, r = 0.7 + 0.25 * std::cos(b);
      s.vertices.push_back(Vec3(r * std::cos(a), r * std::sin(a), 0.25 * std::sin(b)));
      const std::uint32_t i1 = (i + 1) % n, j1 = (j + 1) % m;
      s.triangles.push_back({i * m + j, i1 * m + j, i1 * m + j1});
      s.triangles.push_back({i * m + j, i1 * m + j1, i * m + j1});
    }
  }
  return s;
}

/// How often the surface winds round p, from the solid angles of its triangles (van Oosterom, Strackee 1983):
/// 1 inside, 0 outside.
Real winding_number(const TriangleMesh& mesh, const Vec3& p) {
  Real angle = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Corners c = mesh.corners(t);
    const Vec3 a = c[0] - p, b = c[1] - p, d = c[2] - p;
    const Real an = a.norm(), bn = b.norm(), dn = d.norm();
    angle += 2 * std::atan2(a.dot(b.cross(d)), an * bn * dn + a.dot(b) * dn + b.dot(d) * an + d.dot(a) * bn);
  }
  return angle / (4 * pi);
}

/// Distance to the nearest of all triangles, sign by the winding number.
Real distance_to_all(const TriangleMesh& mesh, const Vec3& p) {
  Real best_sq = all;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Corners c = mesh.corners(t);
    const Vec3 n = (c[1] - c[0]).cross(c[2] - c[0]).normalized();
    best_sq = std::min(best_sq, nearest_on_triangle(c, n, p).distance_sq);
  }
  return (winding_number(mesh, p) > 0.5 ? -1 : 1) * std::sqrt(best_sq);
}

const Vec3 cube = Vec3::Constant(1.1);

void check_against_all_triangles(Solid solid, Real spacing) {
  ASSERT_EQ(solid.set_up(spacing).invalid, MeshInvalid::nothing);
  ASSERT_TRUE(is_valid(solid.params()));
  const TriangleMesh& mesh = solid.mesh;
  Random random(3);
  Real most = 0;
  for (int i = 0; i < 1500; ++i) {
    const Vec3 p = point_in(random, -cube, cube);
    const Real reach = random.uniform(0, 0.5), expected = distance_to_all(mesh, p);
    EXPECT_NEAR(nearest(solid.params(), p, all).distance, expected, 1e-13) << p.transpose();

    std::uint32_t visited = 0;
    const SurfacePoint s = MeshShape::nearest(mesh, p, reach, visited);
    EXPECT_NEAR(s.distance, std::abs(expected) < reach ? expected : reach, 1e-13) << p.transpose();
    EXPECT_LE(visited, max_visits(mesh.grid, reach));
    most = std::max(most, visited / max_visits(mesh.grid, reach));
  }
  EXPECT_GT(most, 0.02);
}

TEST(Mesh, MatchesAllTrianglesAndTheWindingNumber) {
  check_against_all_triangles(box_mesh({0.5, 0.7, 0.3}), 0.2);
  check_against_all_triangles(sphere_mesh(2), 0.1);
  check_against_all_triangles(torus_mesh(), 0.15);
  check_against_all_triangles(spiky_mesh(), 0.1);
  check_against_all_triangles(spiky_mesh(), 5);
}

TEST(Mesh, IsADistanceField) {
  const Pose X_WS{.p = Vec3(0.1, 0.2, 0.3), .q = Random(4).rotation()};
  for (Solid solid : {box_mesh({0.5, 0.7, 0.3}), torus_mesh(), spiky_mesh()}) {
    ASSERT_EQ(solid.set_up(0.2).invalid, MeshInvalid::nothing);
    check_distance_field(solid.params(X_WS), -cube, cube, all, 500);
    check_not_finite(solid.params());
  }
}

TEST(Mesh, BoxOfTrianglesIsABox) {
  const Vec3 b(0.5, 0.7, 0.3);
  Solid solid = box_mesh(b);
  ASSERT_EQ(solid.set_up(0.2).invalid, MeshInvalid::nothing);
  const ShapeParams box{.kind = ShapeKind::box, .half_extents = b};
  Random random(3);
  for (int i = 0; i < 3000; ++i) {
    const Vec3 p = point_in(random, -cube, cube);
    const SurfacePoint s = nearest(solid.params(), p, all), expected = nearest(box, p, all);
    EXPECT_NEAR(s.distance, expected.distance, 1e-14);
    EXPECT_LE((s.n - expected.n).norm(), 1e-12) << p.transpose();
  }
}

TEST(Mesh, FineSphereIsNearlyASphere) {
  Solid solid = sphere_mesh(4);
  ASSERT_EQ(solid.set_up(0.1).invalid, MeshInvalid::nothing);
  Real flattest = 0;  // how far the middle of a face is inside the sphere
  for (std::size_t t = 0; t < solid.triangles.size(); ++t)
    flattest = std::max(flattest, 1 - solid.face_normals[t].dot(solid.mesh.corners(t)[0]));
  EXPECT_LT(flattest, 6e-3);
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p = random.uniform(0.7, 1.3) * random.direction();
    const SurfacePoint s = nearest(solid.params(), p, 0.5);
    EXPECT_GE(s.distance, p.norm() - 1 - 1e-14);
    EXPECT_LE(s.distance, p.norm() - 1 + flattest + 1e-14);
    EXPECT_GT(s.n.dot(p.normalized()), 0.99);
  }
}

TEST(Mesh, HasNormalsOnVerticesEdgesAndFaces) {
  for (Solid solid : {box_mesh({0.5, 0.7, 0.3}), torus_mesh(), spiky_mesh()}) {
    ASSERT_EQ(solid.set_up(0.2).invalid, MeshInvalid::nothing);
    std::vector<Vec3> points = solid.vertices;
    for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
      const Corners c = solid.mesh.corners(t);
      points.insert(points.end(), {(c[0] + c[1]) / 2, (c[0] + c[1] + c[2]) / 3});
    }
    points.push_back(Vec3::Zero());
    check_special_points(solid.params(), points);
  }
}

TEST(Mesh, FacesOfAVertexWeighAlikeHoweverManyTrianglesTheyHave) {
  Solid box = box_mesh({0.5, 0.7, 0.3});
  ASSERT_EQ(box.set_up(0.2).invalid, MeshInvalid::nothing);
  for (std::size_t v = 0; v < 8; ++v)
    EXPECT_LE((box.vertex_normals[v] - box.vertices[v].cwiseSign().normalized()).norm(), 1e-14);
}

TEST(Mesh, RoundingDoesNotTurnTheNormalOnAnEdge) {
  Solid solid = sphere_mesh(2);
  ASSERT_EQ(solid.set_up(0.2).invalid, MeshInvalid::nothing);
  Random random(9);
  for (std::size_t i = 0; i < 3 * solid.triangles.size(); ++i) {
    const Corners t = solid.mesh.corners(i / 3);
    const Vec3 edge = t[(i + 1) % 3] - t[i % 3];
    const Vec3 p = t[i % 3] + random.uniform(0, 1) * edge + 1e-15 * random.direction();
    EXPECT_GT(nearest(solid.params(), p, 0.1).n.dot(p.normalized()), 0.9) << p.transpose();
  }
}

TEST(Mesh, AnswerDoesNotDependOnTheGrid) {
  Solid coarse = spiky_mesh(), fine = spiky_mesh();
  ASSERT_EQ(coarse.set_up(3).invalid, MeshInvalid::nothing);
  ASSERT_EQ(fine.set_up(0.08).invalid, MeshInvalid::nothing);
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p = point_in(random, -cube, cube);
    const SurfacePoint a = nearest(coarse.params(), p, 0.3), b = nearest(fine.params(), p, 0.3);
    EXPECT_EQ(a.distance, b.distance);
    EXPECT_EQ(a.n, b.n);
  }
}

TEST(Mesh, FullArraysSayWhatIsNeeded) {
  Solid solid = torus_mesh();
  ASSERT_EQ(solid.set_up(0.1).invalid, MeshInvalid::nothing);
  const std::size_t cells = solid.mesh.grid.start.size() - 1, entries = solid.mesh.grid.triangles.size();
  EXPECT_EQ(solid.set_up(0.1, cells, entries).invalid, MeshInvalid::nothing);

  MeshReport report = solid.set_up(0.1, cells - 1, entries);
  EXPECT_EQ(report.invalid, MeshInvalid::cells_full);
  EXPECT_EQ(report.number, cells);
  EXPECT_FALSE(is_valid(solid.params()));

  report = solid.set_up(0.1, cells, entries - 1);
  EXPECT_EQ(report.invalid, MeshInvalid::cell_triangles_full);
  EXPECT_EQ(report.number, entries);
  EXPECT_FALSE(is_valid(solid.params()));

  EXPECT_EQ(solid.set_up(1e-12).invalid, MeshInvalid::cells_full);
  ASSERT_EQ(solid.set_up(0.1).invalid, MeshInvalid::nothing);
  solid.half_edges.pop_back();
  EXPECT_EQ(set_up_mesh(solid.vertices, solid.triangles, 0.1, solid.storage(), solid.mesh).invalid,
            MeshInvalid::normals_full);
  EXPECT_FALSE(is_valid(solid.params()));
}

/// Returns the report of the setup for a box changed by `change`.
template <class F>
MeshReport report_of(F&& change) {
  Solid solid = box_mesh({0.5, 0.7, 0.3});
  change(solid);
  const MeshReport report = solid.set_up(0.2);
  EXPECT_EQ(is_valid(solid.params()), report.invalid == MeshInvalid::nothing);
  return report;
}

TEST(Mesh, BrokenMeshesAreNamed) {
  EXPECT_EQ(report_of([](Solid&) {}).invalid, MeshInvalid::nothing);
  EXPECT_EQ(report_of([](Solid& s) { s.triangles.clear(); }).invalid, MeshInvalid::no_triangle);
  const MeshReport vertex = report_of([](Solid& s) { s.vertices[3].y() = all; });
  EXPECT_EQ(vertex.invalid, MeshInvalid::vertex_not_finite);
  EXPECT_EQ(vertex.number, 3u);
  const MeshReport index = report_of([](Solid& s) { s.triangles[4][1] = 8; });
  EXPECT_EQ(index.invalid, MeshInvalid::index_out_of_range);
  EXPECT_EQ(index.number, 4u);
  const MeshReport thin = report_of([](Solid& s) { s.triangles[6] = {2, 6, 6}; });
  EXPECT_EQ(thin.invalid, MeshInvalid::degenerate_triangle);
  EXPECT_EQ(thin.number, 6u);
  EXPECT_EQ(report_of([](Solid& s) { s.triangles.pop_back(); }).invalid, MeshInvalid::not_closed);
  EXPECT_EQ(report_of([](Solid& s) { s.triangles.push_back(s.triangles[0]); }).invalid,
            MeshInvalid::not_closed);
  EXPECT_EQ(report_of([](Solid& s) { std::swap(s.triangles[5][0], s.triangles[5][1]); }).invalid,
            MeshInvalid::not_closed);
  EXPECT_EQ(report_of([](Solid& s) { s.triangles = {{0, 1, 2}, {1, 0, 2}}; }).invalid, MeshInvalid::folded);
  EXPECT_EQ(report_of([](Solid& s) {
              for (TriangleIndices& t : s.triangles) std::swap(t[0], t[1]);
            }).invalid,
            MeshInvalid::inside_out);
  Solid solid = box_mesh(cube);
  for (const Real bad : {0.0, -1.0, all}) EXPECT_EQ(solid.set_up(bad).invalid, MeshInvalid::spacing);
}

}  // namespace
}  // namespace godobject::test_shape_mesh
