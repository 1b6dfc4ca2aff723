// Prescribed joints: g(x, t) = 0, the joint follows the device's coordinates under any load.
#include <iostream>

#include "tests/core/joint/grasper_tool.h"
#include "tests/core/joint/random_tool.h"
#include "tests/core/joint/usual_scene.h"

namespace godobject::test_imposed {
namespace {

using Imposing = TreeJoints<None, PrescribedJoints>;

/// Returns the coordinates of a joint of a kind that can be prescribed.
JointCoordinates coordinates(JointKind kind, const JointFrames& X) {
  JointCoordinates q = JointCoordinates::Zero();
  with_joint(kind, [&](auto joint) {
    if constexpr (requires { joint.coordinates(X); }) q = joint.coordinates(X);
  });
  return q;
}

constexpr std::array imposable{JointKind::hinge, JointKind::slider, JointKind::cylindrical,
                               JointKind::universal};

/// The frames of a joint standing at q with the parent's frame anywhere.
JointFrames frames_at(JointKind kind, const JointCoordinates& q, Random& random) {
  const ChildInParent c = child_in_parent(kind, {.q = Vec3(q[0], q[1], 0), .q_dot = Vec3::Zero()});
  const Mat3 R_WP = random.rotation().toRotationMatrix();
  return {.R_WP = R_WP, .R_WC = R_WP * c.R, .d_W = R_WP * c.d};
}

/// A ball joint beside a prescribed one is not prescribed.
TEST(ImposableJoints, ThreeTurnsHaveNoCoordinates) {
  const JointCoordinates q(1, 2);
  EXPECT_EQ(unwrapped(q, JointCoordinates(7, -7), 3), q);
}

TEST(ImposableJoints, CoordinatesAndTheirFramesAreInverse) {
  Random random(1);
  for (const JointKind kind : imposable)
    for (int n = 0; n < 2000; ++n) {
      const Real first = random.uniform(-pi, pi), second = random.uniform(-pi, pi);
      const bool one = kind == JointKind::hinge || kind == JointKind::slider;
      const JointCoordinates q(first, one ? 0 : second);
      const JointFrames X = frames_at(kind, q, random);
      ASSERT_LT((coordinates(kind, X) - q).norm(), 1e-13);
      with_joint(kind, [&](auto joint) {
        if constexpr (requires { joint.at(X, q); }) {
          const JointFrames joined = joint.at(X, q);
          ASSERT_LT((joined.R_WP - joined.R_WC).norm(), 1e-14);
          ASSERT_LT(joined.d_W.norm(), 1e-14);
        }
      });
    }
}

template <class I>
class Prescribed : public ::testing::Test {};
TYPED_TEST_SUITE(Prescribed, BothIntegrators);

/// A bar on one prescribed joint, its centre 0.1 m along x.
template <class I>
class PrescribedBar : public Running<Articulated<I, Imposing>> {
 public:
  using S = Articulated<I, Imposing>;

  PrescribedBar(JointKind kind, Real h, const RampParams& ramp = {.rise = 0, .lost = 0.02}) {
    this->par.h = h;
    BodyParams<S>& b = this->par.bodies[0];
    b.joint.kind = kind;
    b.joint.C.p = Vec3(-0.1, 0, 0);
    b.joint.motion.prescribed = true;
    b.body = rigid_body(0.5, Vec3(1e-3, 2e-3, 3e-3).asDiagonal());
    b.device = ramp;
    place<S>(this->x, 0, {.X_WB = {.p = Vec3(0.1, 0, 0), .q = Quat::Identity()}, .V_WB = {}});
    this->in.devices[0].target.X_WD = this->x.bodies[0].x.X_WB;
  }
  JointMotionSample& sample() { return this->in.joints[0]; }
  JointCoordinates q() const {
    return coordinates(this->par.bodies[0].joint.kind, joint_of(this->par, this->x, 0).X);
  }
};

/// Every kind along a sine, from rest.
TYPED_TEST(Prescribed, EveryKindFollowsItsCoordinates) {
  for (const JointKind kind : imposable) {
    PrescribedBar<TypeParam> bar(kind, 1e-3);
    bar.par.gravity_W = Vec3(1, -2, -9.81);
    engage_at(bar.x, 0, {.X_WD = bar.in.devices[0].target.X_WD, .V_WD = {}});
    Real worst_error = 0;
    for (int n = 1; n <= 2000; ++n) {
      const Real t = n * bar.par.h, w = 2 * pi;
      const JointCoordinates size(1.5,
                                  kind == JointKind::cylindrical || kind == JointKind::universal ? 0.7 : 0);
      bar.sample() = {.q = size * (0.5 - 0.5 * std::cos(w * t)), .q_dot = size * (0.5 * w * std::sin(w * t))};
      bar.step();
      ASSERT_FALSE(any(bar.out.fault));
      worst_error = std::max(worst_error, (bar.q() - bar.sample().q).norm());
    }
    EXPECT_LT(worst_error, TypeParam::order == 2 ? 1e-6 : 3e-5) << static_cast<int>(kind);
  }
}

/// The grasper with both jaws prescribed.
template <class I>
class PrescribedGrasper : public GrasperTool<I, Imposing> {
 public:
  explicit PrescribedGrasper(Real h) : GrasperTool<I, Imposing>({.h = h}) {
    for (const std::size_t i : {left_jaw, right_jaw}) {
      this->par.bodies[i].joint.motion.prescribed = true;
      this->par.bodies[i].coupling = {};  // the jaw needs none
    }
  }
  void lead_and_follow() {
    const Real t = this->time() + this->par.h;
    for (const std::size_t i : {left_jaw, right_jaw}) {
      const Swing& jaw = i == left_jaw ? this->motion.left : this->motion.right;
      this->in.joints[i].q[0] = jaw.at(t);
      this->in.joints[i].q_dot[0] = jaw.rate(t);
    }
    this->follow();
  }
  Real jaw_angle(std::size_t i) const {
    return coordinates(JointKind::hinge, joint_of(this->par, this->x, i).X)[0];
  }
};

TYPED_TEST(Prescribed, JawsOfTheGrasperFollowTheDevice) {
  PrescribedGrasper<TypeParam> tool(1e-3);
  Real worst_error = 0;
  Drift joints;
  for (int n = 0; n < 3000; ++n) {
    tool.lead_and_follow();
    ASSERT_FALSE(any(tool.out.fault));
    for (const std::size_t i : {left_jaw, right_jaw})
      worst_error = std::max(worst_error, std::abs(tool.jaw_angle(i) - tool.in.joints[i].q[0]));
    joints = worst(joints, tool.drift());
  }
  std::cout << TypeParam::name << ": imposed jaws within " << worst_error << " rad, joints within "
            << joints.m << " m " << joints.rad << " rad\n";
  EXPECT_LT(worst_error, 1e-6);
  EXPECT_LT(joints.m, 1e-7);
}

std::array<Vec3, 4> positions_after(Real h, Real seconds) {
  PrescribedGrasper<TrBdf2> tool(h);
  while (tool.time() < seconds - h / 2) tool.lead_and_follow();
  std::array<Vec3, 4> p;
  for (std::size_t i = 0; i < 4; ++i) p[i] = tool.x.bodies[i].x.X_WB.p;
  return p;
}

TEST(ImposedJaws, AreSecondOrderWithTrBdf2) {
  const std::array<Vec3, 4> fine = positions_after(5e-5, 1);
  const auto error = [&](Real h) {
    const std::array<Vec3, 4> p = positions_after(h, 1);
    Real worst_error = 0;
    for (std::size_t i = 0; i < 4; ++i) worst_error = std::max(worst_error, (p[i] - fine[i]).norm());
    return worst_error;
  };
  const Real coarse = error(2e-3), halved = error(1e-3);
  std::cout << "error " << coarse << " m at 2 ms, " << halved << " m at 1 ms\n";
  EXPECT_GT(coarse, 1e-9);
  EXPECT_GT(std::log2(coarse / halved), 1.9);
}

/// A bar held out level: the joint carries its weight, and the torque of it about the anchor.
TYPED_TEST(Prescribed, ReactionHoldsTheLoad) {
  PrescribedBar<TypeParam> bar(JointKind::hinge, 1e-3);
  bar.par.gravity_W = Vec3(0.3, -9.81, 0.7);
  engage_at(bar.x, 0, {.X_WD = bar.in.devices[0].target.X_WD, .V_WD = {}});
  bar.step(2000);
  const Vec3 weight = 0.5 * bar.par.gravity_W;
  const Wrench& F_C = bar.out.bodies[0].joint.F_C;
  EXPECT_LT((F_C.f + weight).norm(), 1e-9);
  EXPECT_LT((F_C.tau + Vec3(0.1, 0, 0).cross(weight)).norm(), 1e-9);
  EXPECT_NEAR(F_C.tau.z(), 0.1 * 0.5 * 9.81, 1e-9);  // torque about the axis, carried by the joint
  EXPECT_LT(bar.q().norm(), 1e-12);
}

/// Taken up at other coordinates than the joint's: still at first, there with the end of the ramp.
TYPED_TEST(Prescribed, RampStartsWithoutAJumpAndEndsAtTheDevice) {
  PrescribedBar<TypeParam> bar(JointKind::hinge, 1e-3, {.rise = 0.2, .lost = 0.02});
  bar.sample().q[0] = 0.8;
  bar.step();
  EXPECT_EQ(bar.q()[0], 0);
  Real last = 0;
  for (int n = 0; n < 201; ++n) {
    bar.step();
    EXPECT_LT(bar.q()[0] - last, 0.02) << n;  // 0.8 rad in 200 steps, no jump at either end
    EXPECT_GE(bar.q()[0], last - 1e-6) << n;
    last = bar.q()[0];
  }
  EXPECT_NEAR(bar.q()[0], 0.8, 1e-6);
}

/// A device that turns on and on gives its angle within [-pi, pi]: nothing happens where it starts again.
TYPED_TEST(Prescribed, GoesOnThroughTheHalfTurn) {
  PrescribedBar<TypeParam> bar(JointKind::hinge, 1e-3);
  engage_at(bar.x, 0, {.X_WD = bar.in.devices[0].target.X_WD, .V_WD = {}});
  bar.body().w_B.z() = 2;
  bar.body().v_W = Vec3(0, 0.2, 0);
  bar.x.bodies[0].joint.last.q_dot[0] = 2;
  for (int n = 1; n <= 3500; ++n) {
    bar.sample().q[0] = std::remainder(2e-3 * n, 2 * pi);
    bar.sample().q_dot[0] = 2;
    bar.step();
    ASSERT_NEAR(std::remainder(bar.q()[0] - bar.sample().q[0], 2 * pi), 0, 2e-3) << n;
    ASSERT_NEAR(bar.out.bodies[0].V_WB.w.z(), 2, 0.1) << n;
  }
}

template <class I>
PrescribedBar<I> bar_in_motion() {
  PrescribedBar<I> bar(JointKind::hinge, 1e-3);
  engage_at(bar.x, 0, {.X_WD = bar.in.devices[0].target.X_WD, .V_WD = {}});
  for (int n = 1; n <= 500; ++n) {
    bar.sample().q[0] = 1e-3 * n;
    bar.sample().q_dot[0] = 1;
    bar.step();
  }
  return bar;
}

TYPED_TEST(Prescribed, LostSamplesAndReleaseHoldTheCoordinate) {
  for (const bool lost : {true, false}) {
    PrescribedBar<TypeParam> bar = bar_in_motion<TypeParam>();
    bar.in.devices[0].valid = !lost;
    bar.in.devices[0].engaged = lost;
    bar.sample() = {.q = JointCoordinates(-1, 0), .q_dot = JointCoordinates(3, 0)};
    bar.par.gravity_W = Vec3(0, -9.81, 0);
    const Real rest =
        lost ? 0.5 + 1e-3 * bridged_steps : 0.5;  // the first steps without a sample are bridged
    for (int n = 0; n < 500; ++n) {
      bar.step();
      ASSERT_FALSE(any(bar.out.fault));
      ASSERT_NEAR(bar.q()[0], rest, 3.5e-3) << n;
    }
    EXPECT_NEAR(bar.q()[0], rest, 1e-9);
  }
}

TYPED_TEST(Prescribed, NotANumberIsAFaultThatLosesNothing) {
  PrescribedBar<TypeParam> bar = bar_in_motion<TypeParam>(), undisturbed = bar;
  const JointMotionSample good = bar.sample();
  for (Real* bad : {&bar.sample().q[0], &bar.sample().q_dot[1]}) {
    bar.sample() = good;
    *bad = std::nan("");
    bar.step();
    EXPECT_TRUE(has(bar.out.fault, Fault::input_not_finite));
    EXPECT_EQ(bar.hash(), undisturbed.hash());
  }
  bar.sample() = good;
  bar.step();
  undisturbed.step();
  EXPECT_FALSE(any(bar.out.fault));
  EXPECT_EQ(bar.hash(), undisturbed.hash());
}

}  // namespace
}  // namespace godobject::test_imposed
