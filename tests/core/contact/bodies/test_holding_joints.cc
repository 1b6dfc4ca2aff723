// A device grips a jointed body among bodies in contact, and releases it.
#include <gtest/gtest.h>

#include "tests/core/contact/bodies/bricks.h"

namespace godobject::test_holding_joints {
namespace {

template <class I>
struct Box : TouchingBodies<I, 2, HoldingDevice> {
  using Joints = TreeJoints<>;
};

constexpr Real stiffness = 100, h = 1e-3;

/// A brick on the floor, and one hinged about y to the edge of its top: a lid that lies on it.
template <class I>
struct LiddedBox : Pile<Box<I>> {
  LiddedBox() {
    this->par.h = h;
    this->add_floor();
    const Real z = brick_half.z();
    this->add_brick({.X_WB = godobject::at(Vec3(0, 0, z)), .V_WB = {}}, 10 * brick_mass);
    this->add_brick({.X_WB = godobject::at(Vec3(0, 0, 3 * z)), .V_WB = {}});
    auto& joint = this->par.bodies[1].joint;
    const Mat3 about_y = turn_from_z(Vec3::UnitY()).toRotationMatrix();
    joint.kind = JointKind::hinge;
    joint.parent = 0;
    joint.P = {.p = Vec3(-brick_half.x(), 0, z), .R = about_y};
    joint.C = {.p = Vec3(-brick_half.x(), 0, -z), .R = about_y};
    this->par.bodies[1].coupling = {.k = stiffness, .g = 1.4, .k_r = 0.01, .g_r = 1e-5};
    this->par.bodies[1].device.rise = 0.02;
  }
  Vec3 end_of_lid() const { return this->p(1) + this->at(1).X_WB.q * Vec3(brick_half.x(), 0, 0); }
  /// How far the anchors of the hinge are from each other, m.
  Real apart() const {
    const auto& joint = this->par.bodies[1].joint;
    const Pose &P = this->at(0).X_WB, &C = this->at(1).X_WB;
    return (P.p + P.q * joint.P.p - C.p - C.q * joint.C.p).norm();
  }
};

template <class I>
class HoldingJoints : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(HoldingJoints, BothIntegrators);

TYPED_TEST(HoldingJoints, LiftsALidAndLetsItFall) {
  const auto box = std::make_unique<LiddedBox<TypeParam>>();
  auto& device = box->in.devices[1];
  device.target.X_WD.p = Vec3(0.05, 0.01, 0.04);  // anywhere: it is held as it is
  ASSERT_TRUE(box->run(0.2));
  const Real approach = box->end_of_lid().z();

  device.engaged = true;
  Real first = 0;
  for (int i = 0; i < 20; ++i) {
    box->step();
    first = std::max(first, coupling_at(box->par, box->x, 1).F_WB.f.norm());
  }
  EXPECT_LT(first, 1e-6);  // N: gripping is not perceptible

  // the hand goes up on the circle of the lid's middle
  const Vec3 hinge = Vec3(-brick_half.x(), 0, 2 * brick_half.z());
  const Vec3 start = box->p(1) - hinge, from = device.target.X_WD.p;
  Real apart = 0;
  const int steps = 400;
  for (int i = 1; i <= steps; ++i) {
    const Real angle = Real(0.8) * i / steps;
    const Eigen::AngleAxis<Real> turn(-angle, Vec3::UnitY());
    const Quat before = device.target.X_WD.q;
    const Vec3 p_before = device.target.X_WD.p;
    // the device moves as if it were fixed on the lid
    device.target.X_WD = {.p = hinge + turn * (from - hinge), .q = Quat(turn)};
    device.target.V_WD.v = (device.target.X_WD.p - p_before) / h;
    const Eigen::AngleAxis<Real> step(device.target.X_WD.q * before.conjugate());
    device.target.V_WD.w = step.axis() * (step.angle() / h);
    box->step();
    EXPECT_EQ(box->out.fault, Fault::none);
    apart = std::max(apart, box->apart());
  }
  device.target.V_WD = {};
  ASSERT_TRUE(box->run(0.3));
  const Vec3 held = hinge + Eigen::AngleAxis<Real>(-0.8, Vec3::UnitY()) * start;
  EXPECT_LT((box->p(1) - held).norm(), 5e-4);  // it hangs by its weight
  EXPECT_GT(box->end_of_lid().z(), approach + 0.015);
  EXPECT_LT(apart, 1e-5);

  device.engaged = false;
  ASSERT_TRUE(box->run(1));
  EXPECT_NEAR(box->end_of_lid().z(), approach, 1e-5);
  EXPECT_LT(box->fastest(), 1e-9);
}

}  // namespace
}  // namespace godobject::test_holding_joints
