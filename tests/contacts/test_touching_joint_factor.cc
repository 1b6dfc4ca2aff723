// The factor of bodies that touch in loops and are on joints, against the same system in the coordinates of the joints,
// written out in full.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cstdio>

#include "tests/contacts/touching_graphs.h"

namespace godobject::test_touching_joint_factor {
namespace {

using namespace touching_graphs;

constexpr std::size_t most_bodies = 24;
using JointedTree = ContactTree<most_bodies, most_bodies*(most_bodies - 1) / 2, true>;
using JointedFactor = ContactFactor<most_bodies, true>;
using JointedTwists = std::array<AnchorTwist, most_bodies>;

struct JointedSystem {
  System free;  // the same bodies and contacts
  std::unique_ptr<JointedTree> tree = std::make_unique<JointedTree>();
  std::unique_ptr<JointedFactor> factor = std::make_unique<JointedFactor>();
};

/// Turns and slides about a random anchor, some of them with stops.
JointEdge random_joint(const Vec3& p, Random& random) {
  JointEdge edge;
  edge.kind = JointKind::hinge;  // any: what it allows is said by its axes
  edge.a_W = Column(Vec3(p + 0.01 * random.vector()));
  edge.num_axes = random.integer(0, 3);
  edge.num_turns = random.integer(0, edge.num_axes);
  const Mat3 R = random.rotation().toRotationMatrix();
  for (int k = 0; k < 3; ++k) edge.s[static_cast<std::size_t>(k)] = Column(Vec3(R.col(k)));
  for (int k = 0; k < std::min(edge.num_axes, 2); ++k)
    if (random.integer(0, 2) == 0)
      edge.stop_D[static_cast<std::size_t>(k)] = brick_mass * random.log_uniform(1e-6, 1);
  return edge;
}

/// About half of the bodies hang on one before them; at most one on the world.
JointedSystem random_jointed_system(const Graph& graph, Real stiffest, Random& random) {
  JointedSystem s{.free = random_system(graph, stiffest, random)};
  const System& free = s.free;
  std::array<bool, most_bodies> touches{};
  auto& joints = s.tree->joints;
  for (std::uint32_t i = 0; i < free.size; ++i) {
    s.tree->bodies[i].A = free.tree->bodies[i].A;
    joints.p[i] = Column(free.p[i]);
    joints.edges[i] = {};
    touches[i] = true;
    if (random.integer(0, 1) == 0) continue;
    joints.edges[i] = random_joint(free.p[i], random);
    joints.edges[i].parent = i > 0 ? number_below(i, random) : world;
  }
  s.tree->num_pairs = 0;
  for (std::size_t k = 0; k < free.tree->num_pairs; ++k)
    s.tree->pairs[s.tree->num_pairs++] = free.tree->pairs[k];
  make_islands(touches, free.size, *s.tree);
  for (std::size_t k = 0; k < free.tree->num_pairs; ++k) {
    TouchingPair &pair = s.tree->pairs[k], &of_free = free.tree->pairs[k];
    pair.d = Column(Vec3(free.p[pair.child] - free.p[pair.parent]));
    of_free.child = pair.child;
    of_free.parent = pair.parent;
    of_free.d = pair.d;
  }
  return s;
}

/// What the joints allow: V = B (twists of bodies that hang on none, rates of joints), and the stops of these.
struct Allowed {
  LongMatrix B;
  LongVector D_stop;
};
Allowed allowed(const JointedSystem& s) {
  const auto size = static_cast<Eigen::Index>(s.free.size);
  Allowed a{.B = LongMatrix::Zero(6 * size, 6 * size), .D_stop = LongVector::Zero(6 * size)};
  Eigen::Index m = 0;
  for (Eigen::Index i = 0; i < size; ++i) {
    const auto n = static_cast<std::size_t>(i);
    const JointEdge& edge = s.tree->joints.edges[n];
    if (edge.kind == JointKind::free) {
      for (int k = 0; k < 6; ++k) a.B(6 * i + k, m++) = 1;
      continue;
    }
    if (edge.on_body()) {
      const auto p = static_cast<Eigen::Index>(edge.parent);
      const Vec3 d = s.free.p[n] - s.free.p[edge.parent];
      Mat6 X = Mat6::Identity();
      X.block<3, 3>(3, 0) << 0, d.z(), -d.y(), -d.z(), 0, d.x(), d.y(), -d.x(), 0;
      a.B.middleRows(6 * i, 6) = X.cast<Long>() * a.B.middleRows(6 * p, 6);
    }
    for (int k = 0; k < edge.num_axes; ++k) {
      const AnchorTwist S = axis_twist(edge, k, s.tree->joints.p[n]);
      a.B.col(m).segment<6>(6 * i) << S.w.vec().cast<Long>(), S.v.vec().cast<Long>();
      if (k < 2) a.D_stop[m] = edge.stop_D[static_cast<std::size_t>(k)];
      ++m;
    }
  }
  a.B.conservativeResize(Eigen::NoChange, m);
  a.D_stop.conservativeResize(m);
  return a;
}

/// How far the solution is from the one in full, in the norm of A.
Real miss(JointedSystem& s, Random& random) {
  JointedTwists b{}, V{};
  for (std::size_t i = 0; i < s.free.size; ++i)
    b[i] = {.w = Column(Vec3(0.01 * brick_mass * random.vector())),
            .v = Column(Vec3(brick_mass * random.vector()))};
  const auto full = [&](const JointedTwists& twists) {
    Twists all{};
    std::copy(twists.begin(), twists.end(), all.begin());
    return in_full(all, s.free.size);
  };
  const Allowed of = allowed(s);
  const LongMatrix A = in_full(s.free);
  LongMatrix K = of.B.transpose() * A * of.B;
  K.diagonal() += of.D_stop;
  const LongVector exact = of.B * K.ldlt().solve(of.B.transpose() * full(b));
  EXPECT_TRUE(factorize(s.tree->islands[0], false, *s.tree, *s.factor));
  solve(*s.factor, b, V);
  const LongVector off = full(V) - exact;
  return static_cast<Real>(std::sqrt(off.dot(A * off) / exact.dot(A * exact)));
}

TEST(TouchingJointFactor, SolvesRandomGraphsOnRandomJoints) {
  Random random(1);
  for (const Real stiffest : {1e2, 1e4, 1e7, 1e10}) {
    Real worst = 0;
    std::size_t joints = 0;
    for (int n = 0; n < 60; ++n) {
      const auto size = static_cast<std::uint32_t>(random.integer(2, n < 50 ? 8 : most_bodies));
      JointedSystem s =
          random_jointed_system(random_graph(size, number_below(2 * size, random), random), stiffest, random);
      ASSERT_EQ(s.tree->num_islands, 1u);
      for (std::size_t i = 0; i < size; ++i)
        joints += s.tree->joints.edges[i].kind != JointKind::free ? 1 : 0;
      const Real off = miss(s, random);
      worst = std::isfinite(off) ? std::max(worst, off) : std::numeric_limits<Real>::infinity();
    }
    std::printf("on joints, contacts to %.0e: %zu joints, V off by %.1e\n", stiffest, joints, worst);
    EXPECT_GT(joints, 60u);
    EXPECT_LT(worst, 1e3 * std::numeric_limits<Real>::epsilon() * std::max(stiffest, Real(1e3)));
  }
}

}  // namespace
}  // namespace godobject::test_touching_joint_factor
