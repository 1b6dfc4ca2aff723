// Edges of boxes that cross, against all pairs of their edges taken one by one and their separating axes.
#include <gtest/gtest.h>

#include <cstdio>
#include <optional>

#include "tests/core/contact/bodies/bricks.h"
#include "tests/support/box_overlap.h"

namespace godobject::test_touching_edges {
namespace {

using namespace box_overlap;

#ifdef NDEBUG
constexpr int draws = 10000;
#else
constexpr int draws = 300;  // builds with assertions and sanitizers take a hundred times as long
#endif

std::vector<EdgeCrossing> crossings(const PosedBox& a, const PosedBox& b) {
  const auto shape = [](const PosedBox& box) {
    return PlacedShape(
        {.kind = ShapeKind::box, .X_WS = {.p = box.p, .q = Quat(box.R)}, .half_extents = box.h});
  };
  std::vector<EdgeCrossing> all;
  each_crossing(shape(a), shape(b), false, [&](const EdgeCrossing& crossing) { all.push_back(crossing); });
  return all;
}

/// Edges by number: along which axis, and on which side along the next two.
struct EdgeNumbers {
  int i, side_a, j, side_b;
  explicit EdgeNumbers(std::uint32_t edges)
      : i(static_cast<int>(edges >> 6)),
        side_a(static_cast<int>(edges & 3)),
        j(static_cast<int>(edges >> 4 & 3)),
        side_b(static_cast<int>(edges >> 2 & 3)) {}
};
Vec3 middle(const PosedBox& box, int along, int side) {
  Vec3 m = Vec3::Zero();
  for (const int k : {1, 2}) m[(along + k) % 3] = (side & k) != 0 ? 1 : -1;
  return box.p + box.R * m.cwiseProduct(box.h);
}

/// The points of two edges that are nearest to each other, by their distances from the middles.
struct NearestPoints {
  Vec3 on_a, on_b;
  Real along_a, along_b;
};
NearestPoints nearest_points(const EdgeNumbers& edges, const PosedBox& a, const PosedBox& b) {
  const Vec3 u = a.R.col(edges.i), v = b.R.col(edges.j), m_a = middle(a, edges.i, edges.side_a),
             m_b = middle(b, edges.j, edges.side_b);
  Eigen::Matrix<Real, 3, 2> lines;
  lines << u, -v;
  const Eigen::Vector2<Real> at = lines.colPivHouseholderQr().solve(m_b - m_a);
  return {.on_a = m_a + at[0] * u,
          .on_b = m_b + at[1] * v,
          .along_a = std::abs(at[0]),
          .along_b = std::abs(at[1])};
}

Real thinnest(const PosedBox& a, const PosedBox& b) { return std::min(a.h.minCoeff(), b.h.minCoeff()); }

/// Boxes of any size and attitude, or nearly parallel, whose depth is this part of the thinnest half extent.
struct TwoBoxes {
  PosedBox a, b;
};
TwoBoxes random_boxes(Real from, Real to, Random& random) {
  TwoBoxes boxes;
  for (PosedBox* box : {&boxes.a, &boxes.b})
    for (int k = 0; k < 3; ++k) box->h[k] = random.log_uniform(0.003, 0.03);
  boxes.a.p = 0.1 * random.vector();
  boxes.a.R = random.rotation().toRotationMatrix();
  Quat turn = random.rotation();
  if (const int kind = random.integer(0, 3); kind > 1)
    turn = exp_so3(pi / 2 * Vec3::Unit(random.integer(0, 2))) *
           exp_so3(kind == 2 ? Vec3(random.log_uniform(1e-6, 0.3) * random.direction()) : Vec3::Zero());
  boxes.b.R = boxes.a.R * turn.toRotationMatrix();
  // along all axes they are at least as deep if they are as near as along the first one
  const Vec3 way = random.direction();
  const Real depth = random.uniform(from, to) * thinnest(boxes.a, boxes.b);
  Real distance = std::numeric_limits<Real>::infinity();
  const auto nearer = [&](const Vec3& n) {
    const Real both = reach_along(boxes.a, n) + reach_along(boxes.b, n);
    distance = std::min(distance, (both - depth) / std::max(std::abs(n.dot(way)), Real(1e-9)));
  };
  boxes.b.p = boxes.a.p - way;
  for (int i = 0; i < 3; ++i) {
    nearer(boxes.a.R.col(i));
    nearer(boxes.b.R.col(i));
    for (int j = 0; j < 3; ++j)
      if (const EdgeAxis axis = edge_axis(i, j, boxes.a, boxes.b); axis.sine > 1e-3) nearer(axis.n);
  }
  boxes.b.p = boxes.a.p - distance * way;
  return boxes;
}

constexpr Real rounding = 1e-12;  // m

/// The face along which they are least deep looks along n.
bool is_along_least_face(const Vec3& n, const PosedBox& a, const PosedBox& b) {
  const Real least = overlap_of_faces(a, b);
  const auto looks_along = [&](const Vec3& face) {
    return overlap_along(face, a, b) <= least + rounding && std::abs(face.dot(n)) >= same_normal - 1e-9;
  };
  for (int k = 0; k < 3; ++k)
    if (looks_along(a.R.col(k)) || looks_along(b.R.col(k))) return true;
  return false;
}

/// Checks the result of each_crossing() for a pair of edges.
void expect_true(const EdgeCrossing& crossing, const PosedBox& a, const PosedBox& b) {
  const EdgeNumbers edges(crossing.edges);
  ASSERT_LT(std::max(edges.i, edges.j), 3);
  const EdgeAxis axis = edge_axis(edges.i, edges.j, a, b);
  const NearestPoints at = nearest_points(edges, a, b);
  EXPECT_LT((crossing.n_W - axis.n).norm(), 1e-10);
  EXPECT_LT((crossing.p_W - at.on_a).norm(), rounding / (axis.sine * axis.sine));
  EXPECT_LT((crossing.p_W + crossing.d * crossing.n_W - at.on_b).norm(), rounding / (axis.sine * axis.sine));
  EXPECT_LT(at.along_a, a.h[edges.i]);
  EXPECT_LT(at.along_b, b.h[edges.j]);
  EXPECT_GT(crossing.d, -edge_reach * thinnest(a, b) - rounding);
  EXPECT_LE(crossing.d, axis.overlap + rounding);
  // if a nearer face separates them, edges count only round that face
  if (!is_along_least_face(axis.n, a, b)) {
    EXPECT_LT(axis.overlap, 1.25 * std::max(overlap_of_faces(a, b), Real(0)) + edge_reach * thinnest(a, b));
  }
}

/// All edges that cross, of axes along which the boxes are no deeper than along those of their faces.
std::vector<std::uint32_t> to_be_found(const PosedBox& a, const PosedBox& b) {
  std::vector<std::uint32_t> all;
  const Real faces = overlap_of_faces(a, b), reach = edge_reach * thinnest(a, b);
  if (faces < -reach + rounding) return all;
  for (std::uint32_t number = 0; number < 3u << 6; ++number) {
    const EdgeNumbers edges(number);
    if (edges.j == 3) continue;
    const EdgeAxis axis = edge_axis(edges.i, edges.j, a, b);
    if (axis.sine < 1.001 * min_edge_sine ||
        axis.overlap > std::min(std::max(faces, Real(0)), thinnest(a, b)))
      continue;
    const NearestPoints at = nearest_points(edges, a, b);
    const Real d = axis.n.dot(at.on_b - at.on_a), end = 1 - 1.001 * edge_end;
    if (d > -reach + rounding && at.along_a < end * a.h[edges.i] && at.along_b < end * b.h[edges.j])
      all.push_back(number);
  }
  return all;
}

/// For a brick lying across another, all crossing edges are found, however little it is tilted. Along their
/// normal the bricks may be deeper than along those of their faces. With such edges left to the faces,
/// pressed bricks lost their support for a step and sank in by 0.8 mm.
TEST(EdgeCrossings, AreAllThoseOfBricksThatLieOnEachOther) {
  const Vec3 h(0.016, 0.008, 0.005);
  const PosedBox below{.p = Vec3::Zero(), .h = h, .R = Mat3::Identity()};
  Random random(3);
  std::size_t num_checked = 0;
  for (int n = 0; n < draws; ++n) {
    SCOPED_TRACE(::testing::Message() << "draw " << n);
    const Real depth = random.log_uniform(1e-6, 1e-4), tilt = 3 * depth / h.x() * random.uniform(0, 1);
    const Vec3 p(random.uniform(-1, 1) * h.x(), random.uniform(-1, 1) * h.y(), 2 * h.z() - depth);
    const Quat turn = exp_so3(tilt * random.direction()) * exp_so3(random.uniform(0.1, 3) * Vec3::UnitZ());
    const PosedBox above{.p = p, .h = h, .R = turn.toRotationMatrix()};
    const std::vector<EdgeCrossing> found = crossings(above, below);
    for (std::uint32_t number = 0; number < 2u << 6; ++number) {
      const EdgeNumbers edges(number);
      if (edges.j > 1) continue;
      const EdgeAxis axis = edge_axis(edges.i, edges.j, above, below);
      if (axis.sine < 0.05 || axis.n.z() < 0.999) continue;
      const NearestPoints at = nearest_points(edges, above, below);
      if (at.along_a > 0.98 * h[edges.i] || at.along_b > 0.98 * h[edges.j]) continue;
      if (const Real d = axis.n.dot(at.on_b - at.on_a); d < 0 || d > 1e-3) continue;
      ++num_checked;
      EXPECT_TRUE(
          std::any_of(found.begin(), found.end(), [&](const EdgeCrossing& c) { return c.edges == number; }))
          << "edges " << number << ", " << depth << " m deep, tilted by " << tilt;
    }
  }
  EXPECT_GT(num_checked, static_cast<std::size_t>(draws));
}

TEST(EdgeCrossings, AreThoseOfAllPairsOfEdges) {
  Random random(1);
  std::size_t found = 0, num_checked = 0;
  for (int n = 0; n < draws; ++n) {
    SCOPED_TRACE(::testing::Message() << "draw " << n);
    const auto [a, b] = random_boxes(-1.5 * edge_reach, 0.3, random);
    const std::vector<EdgeCrossing> all = crossings(a, b);
    for (const EdgeCrossing& crossing : all) expect_true(crossing, a, b);
    for (const std::uint32_t edges : to_be_found(a, b)) {
      EXPECT_EQ(
          std::count_if(all.begin(), all.end(), [&](const EdgeCrossing& c) { return c.edges == edges; }), 1)
          << "edges " << edges;
      ++num_checked;
    }
    for (std::size_t k = 1; k < all.size(); ++k) EXPECT_LT(all[k - 1].edges, all[k].edges);
    found += all.size();
    if (HasFailure()) return;
  }
  std::printf("%d pairs of boxes: %zu crossings, %zu of them sure\n", draws, found, num_checked);
  EXPECT_GT(num_checked, static_cast<std::size_t>(draws / 4));
}

/// Boxes that an axis of edges parts soonest are deep in each other by those edges.
TEST(EdgeCrossings, PartBoxesTheShortestWay) {
  Random random(2);
  int num_separated = 0, others = 0;
  for (int n = 0; n < draws; ++n) {
    SCOPED_TRACE(::testing::Message() << "draw " << n);
    const auto [a, b] = random_boxes(0, 0.1, random);
    const EdgeAxis least = least_edge_axis(1.001 * min_edge_sine, a, b);
    if (!(least.overlap > 0 && least.overlap < overlap(a, b) + rounding &&
          least.overlap < overlap_of_faces(a, b) - rounding))
      continue;
    std::optional<EdgeCrossing> way;
    bool at_end = false;  // where a sphere is
    for (std::uint32_t number = 0; number < 3u << 6; ++number) {
      const EdgeNumbers edges(number);
      if (edges.i != least.i || edges.j != least.j) continue;
      const NearestPoints at = nearest_points(edges, a, b);
      if (std::abs(least.n.dot(at.on_b - at.on_a) - least.overlap) > rounding) continue;
      at_end = at_end || at.along_a > (1 - 1.001 * edge_end) * a.h[edges.i] ||
               at.along_b > (1 - 1.001 * edge_end) * b.h[edges.j];
    }
    if (at_end) continue;
    for (const EdgeCrossing& crossing : crossings(a, b)) {
      const EdgeNumbers edges(crossing.edges);
      const bool is_it =
          edges.i == least.i && edges.j == least.j && std::abs(crossing.d - least.overlap) < rounding;
      if (is_it) way = crossing;
      else ++others;
    }
    ++num_separated;
    ASSERT_TRUE(way.has_value()) << least.i << ", " << least.j << ": " << least.overlap;
    ASSERT_LT((way->n_W - least.n).norm(), 1e-10);
    ASSERT_GT(way->n_W.dot(a.p - b.p), 0);
    // by that much and no more
    PosedBox moved = a;
    moved.p += (way->d + 1e-9) * way->n_W;
    EXPECT_LT(overlap(moved, b), 0);
  }
  std::printf("%d pairs of boxes are parted by edges, with %d crossings beside\n", num_separated, others);
  EXPECT_GT(num_separated, draws / 20);
}

TEST(EdgeCrossings, AreTheSameSeenFromTheOtherBox) {
  Random random(3);
  std::size_t found = 0;
  for (int n = 0; n < draws; ++n) {
    SCOPED_TRACE(::testing::Message() << "draw " << n);
    const auto [a, b] = random_boxes(-edge_reach, 0.3, random);
    const std::vector<EdgeCrossing> of_a = crossings(a, b), of_b = crossings(b, a);
    ASSERT_EQ(of_a.size(), of_b.size());
    for (const EdgeCrossing& crossing : of_a) {
      const std::uint32_t e = crossing.edges,
                          swapped = (e >> 4 & 3) << 6 | e >> 6 << 4 | (e & 3) << 2 | (e >> 2 & 3);
      const auto other =
          std::find_if(of_b.begin(), of_b.end(), [&](const EdgeCrossing& c) { return c.edges == swapped; });
      ASSERT_NE(other, of_b.end());
      EXPECT_NEAR(other->d, crossing.d, rounding);
      EXPECT_LT((other->n_W + crossing.n_W).norm(), 1e-10);
      EXPECT_LT((other->p_W - crossing.p_W - crossing.d * crossing.n_W).norm(), 1e-8);
    }
    found += of_a.size();
  }
  EXPECT_GT(found, static_cast<std::size_t>(draws / 4));
}

TEST(EdgeCrossings, AreNoneBeyondTheirReach) {
  Random random(4);
  for (int n = 0; n < draws; ++n) {
    const auto [a, b] = random_boxes(-5, -1.001 * edge_reach, random);
    ASSERT_LT(overlap(a, b), -edge_reach * thinnest(a, b));
    EXPECT_TRUE(crossings(a, b).empty()) << "draw " << n << ", " << overlap(a, b) / thinnest(a, b);
  }
}

}  // namespace
}  // namespace godobject::test_touching_edges
