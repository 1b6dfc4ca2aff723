// Stops at the ends of joints: the law (19), and its effect on a joint that is thrown or pressed against it.
#include <iostream>

#include "tests/core/joint/grasper_tool.h"
#include "tests/core/joint/usual_scene.h"

namespace godobject::test_stops {
namespace {

using WithStops = TreeJoints<JointStops>;
constexpr Real no_stop = std::numeric_limits<Real>::infinity();

/// Force of the stop on the coordinate, from its terms for a stage of no length to speak of.
Real stop_force(const StopParams& stop, Real q, Real rate) {
  constexpr Real h = 1e-9;
  return stop_terms(stop, q, rate, h).tau / h;
}

constexpr StopParams stop{.lower = -0.3, .upper = 0.5, .k = 40, .g = 3, .width = 0.02};

TEST(StopLaw, IsTheFormula) {
  for (const Real d : {0.001, 0.015, 0.02, 0.05, 1.0})
    for (const Real rate : {-2.0, 0.0, 2.0}) {
      const Real s = std::min(d, stop.width);
      const Real k_part = stop.k * s * (d - s / 2) / stop.width, g_part = stop.g * s / stop.width;
      EXPECT_NEAR(stop_force(stop, stop.upper + d, rate), -(k_part + g_part * std::max(rate, 0.0)), 1e-9)
          << d;
      EXPECT_NEAR(stop_force(stop, stop.lower - d, rate), k_part - g_part * std::min(rate, 0.0), 1e-9) << d;
    }
  for (const Real q : {-0.3, 0.0, 0.5}) EXPECT_EQ(stop_force(stop, q, 3), 0);
}

TEST(StopLaw, IsTheSlopeOfItsEnergy) {
  constexpr Real dq = 1e-6;
  for (Real q = -0.4; q < 0.6; q += 0.00317) {
    const Real slope = (stop_energy(stop, q + dq) - stop_energy(stop, q - dq)) / (2 * dq);
    EXPECT_NEAR(stop_force(stop, q, 0), -slope, 1e-7) << q;
  }
}

/// The linear terms of a stage are the derivatives of the law: D = h (g + h k).
TEST(StopLaw, TermsAreItsDerivatives) {
  constexpr Real h = 1e-3, dq = 1e-7;
  for (const Real q : {0.505, 0.515, 0.6, -0.305, -0.5})
    for (const Real rate : {-1.0, 1.0}) {
      const Real k = -(stop_force(stop, q + dq, 0) - stop_force(stop, q - dq, 0)) / (2 * dq);
      const Real g = -(stop_force(stop, q, rate + dq) - stop_force(stop, q, rate - dq)) / (2 * dq);
      EXPECT_NEAR(stop_terms(stop, q, rate, h).D, h * (g + h * k), 1e-6 * h) << q;
    }
}

/// Force and its slope have no jump where the stop begins and where it is fully in.
TEST(StopLaw, IsEnteredSmoothly) {
  constexpr Real dq = 1e-5;
  for (Real q = stop.upper - 0.01; q < stop.upper + 0.05; q += dq) {
    const Real step = stop_force(stop, q + dq, 1) - stop_force(stop, q, 1);
    EXPECT_LE(std::abs(step), 1.01 * dq * (stop.k + stop.g / stop.width)) << q;
    EXPECT_LE(step, 1e-9) << q;
  }
}

/// A bar on one joint, its centre 0.1 m beside the axis.
template <class I>
class Bar : public Running<Articulated<I, WithStops>> {
 public:
  using S = Articulated<I, WithStops>;

  Bar(JointKind kind, Real h) {
    this->par.h = h;
    joint().kind = kind;
    joint().C.p = Vec3(-0.1, 0, 0);
    this->par.bodies[0].body = rigid_body(0.5, Vec3(1e-3, 2e-3, 3e-3).asDiagonal());
    place<S>(this->x, 0, {.X_WB = {.p = Vec3(0.1, 0, 0), .q = Quat::Identity()}, .V_WB = {}});
    engage_at<S>(this->x, 0, {.X_WD = this->x.bodies[0].x.X_WB, .V_WD = {}});
    this->in.devices[0].target.X_WD = this->x.bodies[0].x.X_WB;
  }
  auto& joint() { return this->par.bodies[0].joint; }
  StopParams& stop(std::size_t c) { return joint().stop.stops[c]; }
  /// Moves it with V about the anchor.
  void throw_at(const Twist& V) {
    const Pose X = this->x.bodies[0].x.X_WB;
    place<S>(this->x, 0, {.X_WB = X, .V_WB = {.w = V.w, .v = V.v + V.w.cross(X.p)}});
  }
  template <class Joint>
  JointCoordinates q() const {
    return Joint::coordinates(joint_of(this->par, this->x, 0).X);
  }
};

template <class I>
class Stops : public ::testing::Test {};
TYPED_TEST_SUITE(Stops, BothIntegrators);

/// A coordinate thrown at its upper stop. The energy stored by the stop is not counted. A body that enters a
/// stiff stop within a step is deeper than its kinetic energy explains, but does not regain that energy.
struct Throw {
  Real beyond = 0, energy = 0;  // deepest, and highest kinetic energy as a share of the first
  bool back = false;
};

template <class I, class Joint>
void expect_bounces(Bar<I>& bar, int c, const StopParams& end, Real inertia, Real rate) {
  Throw t;
  const Real first = kinetic_energy(bar.par, bar.x);
  for (int n = 0; n < 400000 && !t.back; ++n) {
    bar.step();
    EXPECT_FALSE(any(bar.out.fault));
    const Real q = bar.template q<Joint>()[c];
    t.beyond = std::max(t.beyond, q - end.upper);
    t.energy = std::max(t.energy, kinetic_energy(bar.par, bar.x) / first);
    t.back = t.beyond > 0 && q < end.upper;
  }
  const Real compression = end.k > 0 ? std::sqrt(inertia / end.k) * rate : 0;
  EXPECT_LT(t.beyond, compression + end.width + bar.par.h * rate);
  EXPECT_LT(t.energy, 1 + 1e-9);
  EXPECT_TRUE(t.back);
}

TYPED_TEST(Stops, HingeThrownAtItsStop) {
  const Real inertia = 3e-3 + 0.5 * 0.01;
  for (int decade = 0; decade <= 8; decade += 2)
    for (const Real h : {1e-4, 1e-3, 5e-3})
      for (const Real rate : {0.1, 1.0, 8.0})
        for (const Real zeta : {0.0, 1.0}) {
          Bar<TypeParam> bar(JointKind::hinge, h);
          const Real k = std::pow(10, decade);
          bar.stop(0) = {.upper = 0.2, .k = k, .g = 2 * zeta * std::sqrt(k * inertia), .width = 0.02};
          bar.throw_at({.w = Vec3(0, 0, rate), .v = Vec3::Zero()});
          SCOPED_TRACE(testing::Message() << "k " << k << " h " << h << " rate " << rate << " zeta " << zeta);
          expect_bounces<TypeParam, HingeJoint>(bar, 0, bar.stop(0), inertia, rate);
        }
}

/// Each coordinate of the joints that have two, and the slider's.
TYPED_TEST(Stops, EachCoordinate) {
  const auto bar_with = [](JointKind kind, std::size_t c) {
    Bar<TypeParam> bar(kind, 1e-3);
    bar.stop(c) = {.upper = 0.1, .k = 1e4, .width = 0.01};
    return bar;
  };
  {
    auto bar = bar_with(JointKind::universal, 0);
    bar.throw_at({.w = Vec3(1, 0, 0), .v = Vec3::Zero()});
    expect_bounces<TypeParam, UniversalJoint>(bar, 0, bar.stop(0), 1e-3, 1);
  }
  {
    auto bar = bar_with(JointKind::universal, 1);
    bar.throw_at({.w = Vec3(0, 1, 0), .v = Vec3::Zero()});
    expect_bounces<TypeParam, UniversalJoint>(bar, 1, bar.stop(1), 2e-3 + 0.5 * 0.01, 1);
  }
  {
    auto bar = bar_with(JointKind::cylindrical, 0);
    bar.throw_at({.w = Vec3(0, 0, 1), .v = Vec3::Zero()});
    expect_bounces<TypeParam, CylindricalJoint>(bar, 0, bar.stop(0), 3e-3 + 0.5 * 0.01, 1);
  }
  for (const JointKind kind : {JointKind::cylindrical, JointKind::slider}) {
    const bool two = kind == JointKind::cylindrical;
    auto bar = bar_with(kind, two ? 1 : 0);
    bar.throw_at({.w = Vec3::Zero(), .v = Vec3(0, 0, 1)});
    if (two) expect_bounces<TypeParam, CylindricalJoint>(bar, 1, bar.stop(1), 0.5, 1);
    else expect_bounces<TypeParam, SliderJoint>(bar, 0, bar.stop(0), 0.5, 1);
  }
}

/// A jaw whose target is 0.4 rad beyond its stop: both springs balance, k_r (0.4 - d) = k (d - width / 2).
TYPED_TEST(Stops, JawPressedByTheCouplingRestsWhereTheSpringsBalance) {
  Bar<TypeParam> bar(JointKind::hinge, 1e-3);
  const Real k_r = 0.5, k = 7;
  bar.stop(0) = {.lower = -0.2, .upper = no_stop, .k = k, .g = 0.1, .width = 0.01};
  bar.par.bodies[0].coupling = {.k = 0, .g = 0, .k_r = k_r, .g_r = 0.05};
  bar.in.devices[0].target.X_WD.q = exp_so3(Vec3(0, 0, -0.6));
  bar.step(20000);
  const Real d = (k_r * 0.4 + k * 0.005) / (k + k_r);
  ASSERT_GT(d, 0.01);
  EXPECT_NEAR((bar.template q<HingeJoint>()[0]), -0.2 - d, 1e-9);
  // the joint carries the stop's torque: in balance with the coupling's on the same body
  EXPECT_NEAR(coupling_at(bar.par, bar.x, 0).F_WB.tau.z(), -k * (d - 0.005), 1e-9);
}

/// Pulled out of its stop by a spring that is stronger: the stop does not hold on to it.
TYPED_TEST(Stops, NeverPulls) {
  for (const Real k : {1.0, 1e4, 1e8}) {
    Bar<TypeParam> bar(JointKind::hinge, 1e-3);
    bar.stop(0) = {.lower = -no_stop, .upper = 0, .k = k, .g = std::sqrt(k), .width = 0.01};
    auto free = bar;
    free.stop(0) = {};
    for (auto* b : {&bar, &free}) {
      b->par.bodies[0].coupling = {.k = 0, .g = 0, .k_r = 1e3, .g_r = 1};
      b->in.devices[0].target.X_WD.q = exp_so3(Vec3(0, 0, -1));
    }
    for (int n = 0; n < 200; ++n) {
      bar.step();
      free.step();
      ASSERT_LE((bar.template q<HingeJoint>()[0]), (free.template q<HingeJoint>()[0]) + 1e-9)
          << k << ' ' << n;
    }
  }
}

}  // namespace
}  // namespace godobject::test_stops
