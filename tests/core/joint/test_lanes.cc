// Bodies in groups of four against single ones, and operations of groups against plain numbers.
#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "core/math/block.h"
#include "tests/core/joint/random_tool.h"
#include "tests/core/joint/usual_scene.h"

namespace godobject::test_lanes {
namespace {

template <class I, class T>
struct With : Articulated<I> {
  using Number = T;
};

/// A random tool on springs whose targets circle.
template <Scene S>
class Circling : public Running<S> {
 public:
  Circling(std::size_t bodies, unsigned seed) {
    Random random(seed);
    this->par.num_bodies = bodies;
    this->par.gravity_W = Vec3(1, 2, -9.81);
    for (std::size_t i = 0; i < bodies; ++i) {
      add_random_body(this->par, i, 0.1, random);
      const RigidBodyParams& body = this->par.bodies[i].body;
      this->par.bodies[i].coupling = spring(body, 1000 * body.m, 1000 * principal_moments(body.I_B).z());
    }
    place_randomly(this->par, this->x, 0.1, 0.5, random);
    for (std::size_t i = 0; i < bodies; ++i) {
      start_[i] = this->x.bodies[i].x.X_WB;
      engage_at<S>(this->x, i, {.X_WD = start_[i], .V_WD = {}});
    }
  }

  void follow() {
    const Real t = static_cast<Real>(this->x.tick + 1) * this->par.h;
    for (std::size_t i = 0; i < this->par.num_bodies; ++i) {
      const Vec3 axis_W(0.5, 1, -0.3);
      const Quat turn = exp_so3(Vec3(0.2 * std::sin(t) * axis_W));
      this->in.devices[i].target.X_WD = {.p = start_[i].p + 0.02 * std::sin(t) * axis_W,
                                         .q = turn * start_[i].q};
      this->in.devices[i].target.V_WD = {.w = 0.2 * std::cos(t) * axis_W, .v = 0.02 * std::cos(t) * axis_W};
    }
    this->step();
  }

 private:
  std::array<Pose, S::max_bodies> start_;
};

template <class I>
class LanesOf : public ::testing::Test {};
using Integrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(LanesOf, Integrators);

Real pose_difference(const RigidBodyState& a, const RigidBodyState& b) {
  return (a.X_WB.p - b.X_WB.p).norm() + (a.X_WB.q.coeffs() - b.X_WB.q.coeffs()).norm();
}
Real velocity_difference(const RigidBodyState& a, const RigidBodyState& b) {
  return (a.v_W - b.v_W).norm() + (a.w_B - b.w_B).norm();
}

/// From one body to two full groups: lanes without a body change nothing.
TYPED_TEST(LanesOf, GroupsOfFourAreTheBodiesOneByOne) {
  using Plain = With<TypeParam, Real>;
  using Packed = With<TypeParam, Pack>;
  static_assert(lanes<Plain> == 1 && lanes<Packed> == 4);
  for (const std::size_t bodies : {1u, 2u, 3u, 4u, 5u, 7u, 8u})
    for (unsigned seed = 1; seed <= 4; ++seed) {
      Circling<Plain> plain(bodies, seed);
      Circling<Packed> packed(bodies, seed);
      for (int n = 0; n < 2000; ++n) {
        plain.follow();
        packed.follow();
      }
      ASSERT_EQ(plain.x.tick, 2000u);
      ASSERT_EQ(packed.x.tick, 2000u);
      for (std::size_t i = 0; i < bodies; ++i) {
        SCOPED_TRACE(testing::Message() << bodies << " bodies, seed " << seed << ", body " << i);
        const RigidBodyState &a = plain.x.bodies[i].x, &b = packed.x.bodies[i].x;
        EXPECT_LT(pose_difference(a, b), 1e-12);
        EXPECT_LT(velocity_difference(a, b), 1e-10);  // a position's rounding, by the step
        const Wrench &F = plain.out.bodies[i].joint.F_C, &G = packed.out.bodies[i].joint.F_C;
        EXPECT_LT((F.f - G.f).norm() + (F.tau - G.tau).norm(), 1e-8 * (1 + F.f.norm() + F.tau.norm()));
      }
    }
}

class Numbers : public ::testing::Test {
 protected:
  Vec3 vector() { return random_.vector(); }
  Mat3 matrix() {
    Mat3 m;
    for (int c = 0; c < 3; ++c) m.col(c) = vector();
    return m;
  }
  Pack pack() { return {random_.normal(), random_.normal(), random_.normal(), random_.normal()}; }

  Random random_{1};
};

Block block(const Mat3& m) {
  return {{Column(Vec3(m.col(0))), Column(Vec3(m.col(1))), Column(Vec3(m.col(2)))}};
}
Mat3 plain(const Block& b) {
  Mat3 m;
  for (int c = 0; c < 3; ++c) m.col(c) = b.col[static_cast<std::size_t>(c)].vec();
  return m;
}

TEST_F(Numbers, BlocksAreMatrices) {
  for (int n = 0; n < 1000; ++n) {
    const Mat3 A = matrix(), B = matrix();
    const Vec3 a = vector(), b = vector();
    const Column ca(a), cb(b);
    const Block bA = block(A), bB = block(B);
    EXPECT_LT((plain(bA * bB) - A * B).norm(), 1e-14);
    EXPECT_LT(((bA * cb).vec() - A * b).norm(), 1e-14);
    EXPECT_LT((times_transposed(bA, cb).vec() - A.transpose() * b).norm(), 1e-14);
    EXPECT_LT((plain(outer(ca, cb)) - a * b.transpose()).norm(), 1e-14);
    EXPECT_LT((cross(ca, cb).vec() - a.cross(b)).norm(), 1e-14);
    EXPECT_LT((plain(cross(ca, bA)) - skew(a) * A).norm(), 1e-14);
    EXPECT_LT((plain(cross(bA, ca)) - A * skew(a)).norm(), 1e-14);
    EXPECT_LT((plain(transposed(bA.col[0], bA.col[1], bA.col[2])) - A.transpose()).norm(), 1e-300);
    EXPECT_NEAR(dot(ca, cb), a.dot(b), 1e-14);
    EXPECT_LT((plain(bA + bB) - (A + B)).norm() + (plain(bA - bB) - (A - B)).norm(), 1e-300);
    const Mat3 regular = A + 5 * Mat3::Identity();
    EXPECT_LT((plain(inverse(block(regular))) - regular.inverse()).norm(),
              1e-13 * regular.inverse().norm() + 1e-14);
  }
}

TEST_F(Numbers, ColumnsOfFourBodiesAreTheirVectors) {
  Vector3<Pack> all;
  std::array<Vec3, 4> each;
  for (std::size_t j = 0; j < 4; ++j) set_lane(all, j, each[j] = vector());
  for (std::size_t j = 0; j < 4; ++j) {
    EXPECT_EQ(columns(all)[j].vec(), each[j]);
    EXPECT_EQ(lane(all, j), each[j]);
  }
}

TEST_F(Numbers, PacksAreFourNumbers) {
  for (int n = 0; n < 1000; ++n) {
    const Pack a = pack(), b = pack();
    const Pack sum = a + b, less = a - b, product = a * b, quotient = a / b, minus = -a, root = sqrt(a * a);
    const Pack smaller = min(a, b), size = abs(a), chosen = select(a <= b, a, b), other = select(a > b, a, b);
    bool below = false;
    for (std::size_t j = 0; j < 4; ++j) {
      EXPECT_EQ(sum[j], a[j] + b[j]);
      EXPECT_EQ(less[j], a[j] - b[j]);
      EXPECT_EQ(product[j], a[j] * b[j]);
      EXPECT_EQ(quotient[j], a[j] / b[j]);
      EXPECT_EQ(minus[j], -a[j]);
      EXPECT_EQ(root[j], std::sqrt(a[j] * a[j]));
      EXPECT_EQ(smaller[j], std::min(a[j], b[j]));
      EXPECT_EQ(size[j], std::abs(a[j]));
      EXPECT_EQ(chosen[j], std::min(a[j], b[j]));
      EXPECT_EQ(other[j], std::max(a[j], b[j]));
      below |= a[j] < b[j];
    }
    EXPECT_EQ(any(a < b), below);
  }
}

/// Neither side of a NaN is chosen by accident: comparisons with it are false in its lane alone.
TEST_F(Numbers, NotANumberStaysInItsLane) {
  const Pack a(1, std::nan(""), 3, -1);
  const Pack chosen = select(a < Pack(2), Pack(10), Pack(20));
  EXPECT_EQ(chosen[0], 10);
  EXPECT_EQ(chosen[1], 20);
  EXPECT_EQ(chosen[2], 20);
  EXPECT_EQ(chosen[3], 10);
}

}  // namespace
}  // namespace godobject::test_lanes
