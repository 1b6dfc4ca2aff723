// Coulomb friction against known results: the cone, sliding, rolling, spinning, and that it never drives.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/contact/contact_scene.h"

namespace godobject::test_friction {
namespace {

constexpr Real g = 9.81, m = 0.1, mu = 0.3, half_edge = 0.02, radius = 0.01;
constexpr Real load = m * g / 4;  // of a foot
constexpr ContactLaw law{.k = 2e5, .c = 200, .mu = mu, .k_t = 2e5, .c_t = 200};

/// A table on four feet on the plane z = 0, or a ball, pushed by a hand.
template <class I>
class Slider : public Running<Touching<I, 1, 4, AdmittanceDevice, 1>> {
 public:
  using S = Touching<I, 1, 4, AdmittanceDevice, 1>;

  explicit Slider(const ContactLaw& law_in_stage = law, int feet = 4) {
    const Real spread = feet == 4 ? half_edge : 0;
    this->par.gravity_W = Vec3(0, 0, -g);
    // a table is a disc of its size, its centre of mass low; a ball is solid
    const Real I_B = feet == 4 ? m * spread * spread : 0.4 * m * radius * radius;
    this->par.bodies[0].body = rigid_body(m, I_B * Mat3::Identity());
    this->par.bodies[0].device.rise = 0;
    for (int i = 0; i < feet; ++i)
      add_sphere(this->par, 0, Vec3(i % 2 == 0 ? spread : -spread, i < 2 ? spread : -spread, 0), radius);
    add_plane(this->par);
    set_law(this->par, law_in_stage);
    const Real depth = m * g / (feet * law_in_stage.k);
    place(this->x, 0, {.X_WB = {.p = Vec3(0, 0, radius - depth), .q = Quat::Identity()}, .V_WB = {}});
  }

  /// The plane's slope, by the direction of gravity: down along `direction`.
  void tilt(Real slope, const Vec3& direction = Vec3::UnitX()) {
    this->par.gravity_W = g / std::sqrt(1 + slope * slope) * (slope * direction - Vec3::UnitZ());
  }
  void push(const Vec3& f) { this->device().F_WB.f = f; }
  void run(Real seconds) {
    for (const std::uint64_t end = this->x.tick + std::uint64_t(std::lround(seconds / this->par.h));
         this->x.tick < end;) {
      this->step();
      ASSERT_FALSE(any(this->out.fault));
    }
  }
  Vec3 v() const { return this->x.bodies[0].x.v_W; }
  Vec3 p() const { return this->x.bodies[0].x.X_WB.p; }
  Real spin() const { return this->x.bodies[0].x.w_B.z(); }

  /// m/s, over two seconds.
  Real drift() {
    const Vec3 before = p();
    run(2);
    return (p() - before).norm() / 2;
  }
};

template <class I>
class Friction : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(Friction, BothIntegrators);

const Vec3 directions[] = {Vec3::UnitX(), Vec3(0.6, -0.8, 0), Vec3(-0.8, -0.6, 0)};

TYPED_TEST(Friction, SticksOnASlopeBelowTheCone) {
  for (const Vec3& direction : directions) {
    Slider<TypeParam> table;
    table.tilt(0.99 * mu, direction);
    table.run(1);
    const Real drift = table.drift();
    std::printf("%s: slope 0.99 mu, drift %.1e m/s\n", TypeParam::name, drift);
    EXPECT_LT(drift, 1e-6);
    EXPECT_LT(table.p().template head<2>().norm(), 1e-4);
  }
}

TYPED_TEST(Friction, SlipsOnASlopeAboveTheCone) {
  for (const Real slope : {1.05 * mu, 2 * mu, 1.0})
    for (const Vec3& direction : directions) {
      Slider<TypeParam> table;
      table.tilt(slope, direction);
      table.run(0.5);
      const Vec3 v = table.v();
      table.run(0.5);
      const Vec3 a = (table.v() - v) / 0.5;
      const Real expected = g / std::sqrt(1 + slope * slope) * (slope - mu);
      EXPECT_NEAR(a.dot(direction), expected, 0.01 * expected) << slope;
      EXPECT_LT((a - a.dot(direction) * direction).norm(), 0.01 * expected) << slope;
    }
}

/// Pushed harder for a while: slips, comes to rest, sticks.
TYPED_TEST(Friction, SticksSlipsSticks) {
  for (const Vec3& direction : directions) {
    Slider<TypeParam> table;
    const Real cone = mu * m * g;
    table.push(0.9 * cone * direction);
    table.run(1);
    EXPECT_LT(table.drift(), 1e-6);
    const Vec3 start = table.p();
    table.push(2 * cone * direction);
    table.run(0.2);
    const Real v = cone / m * 0.2;
    EXPECT_NEAR(table.v().dot(direction), v, 0.01 * v);
    table.push(0.5 * cone * direction);
    table.run(1);
    const Real way = 0.5 * v * 0.2 + 0.5 * v * v / (0.5 * cone / m);
    EXPECT_NEAR((table.p() - start).dot(direction), way, 0.01 * way);
    EXPECT_LT(table.drift(), 1e-6);
  }
}

/// Energy with that of the contact springs falls in every step, whatever shares spring and damper have.
TYPED_TEST(Friction, NeverDrivesASlidingBody) {
  for (const Real c_t : {0.0, 20.0, 200.0, 2e4})
    for (const Real k_t : {0.0, 2e3, 2e5, 2e7}) {
      if (k_t + c_t == 0) continue;
      Slider<TypeParam> table({.k = law.k, .c = law.c, .mu = mu, .k_t = k_t, .c_t = c_t});
      table.body().v_W = Vec3(0.3, -0.4, 0);
      const Real first = total_energy(table.par, table.x);
      Real before = first, v_1 = 0, v_2 = 0;
      for (int n = 0; n < 500; ++n) {
        table.step();
        const Real now = total_energy(table.par, table.x);
        ASSERT_LE(now - before, 1e-6 * first)
            << TypeParam::name << " k_t " << k_t << " c_t " << c_t << " step " << n;
        before = now;
        if (n == 50) v_1 = table.v().norm();
        if (n == 100) v_2 = table.v().norm();
      }
      EXPECT_NEAR((v_1 - v_2) / 0.05, mu * g, 0.01 * mu * g) << "k_t " << k_t << " c_t " << c_t;
      EXPECT_LT(table.v().norm(), 1e-2);
    }
}

/// A hand stops a slipping body and releases it: no stored drag moves it afterwards.
TYPED_TEST(Friction, LeavesABodyWhereItWasStopped) {
  Slider<TypeParam> table({.k = law.k, .c = law.c, .mu = mu, .k_t = 2e5, .c_t = 2e4});
  table.body().v_W = Vec3(1, 0, 0);
  table.run(0.1);
  const Real v = table.v().x();
  ASSERT_GT(v, 0.5);
  table.push(Vec3(-(m * v / 0.002 - mu * m * g), 0, 0));
  table.run(0.002);
  table.push(Vec3::Zero());
  Real fastest = 0;
  for (int n = 0; n < 300; ++n) {
    table.step();
    fastest = std::max(fastest, std::abs(table.v().x()));
  }
  EXPECT_LT(fastest, 2 * v * mu * g * 0.002 + 1e-2);
  EXPECT_LT(table.drift(), 1e-6);
}

/// A ball that is thrown along the plane slips until it rolls, at 5/7 of its speed.
TYPED_TEST(Friction, LetsABallRoll) {
  Slider<TypeParam> ball(law, 1);
  ball.body().v_W = Vec3(0.7, 0, 0);
  ball.run(1);
  EXPECT_NEAR(ball.v().x(), 0.5, 0.005);
  EXPECT_NEAR(ball.body().X_WB.q.conjugate().norm(), 1, 1e-12);
  const Vec3 w_W = to_world(ball.body().X_WB.q, ball.body().w_B);
  EXPECT_NEAR(w_W.y() * radius, ball.v().x(), 1e-3);
}

/// A spinning table slows down by 4 feet's friction at their distance, and stays where it stops.
TYPED_TEST(Friction, StopsASpinningTable) {
  Slider<TypeParam> table;
  constexpr Real spin = 60;
  table.body().w_B = Vec3(0, 0, spin);
  const Real arm = std::sqrt(Real(2)) * half_edge, I_z = table.par.bodies[0].body.I_B(2, 2);
  const Real slowing = 4 * mu * load * arm / I_z;
  table.run(0.1);
  EXPECT_NEAR(table.spin(), spin - 0.1 * slowing, 0.01 * spin);
  table.run(1);
  EXPECT_LT(std::abs(table.spin()), 1e-6);
  EXPECT_LT(table.p().template head<2>().norm(), 1e-4);
}

TYPED_TEST(Friction, OfNothingHoldsNothing) {
  for (const Real k_t : {0.0, 2e5}) {
    Slider<TypeParam> table({.k = law.k, .c = law.c, .mu = 0, .k_t = k_t, .c_t = k_t / 1000});
    table.tilt(0.1);
    table.body().v_W = Vec3(0, 1, 0);
    table.body().w_B = Vec3(0, 0, 5);
    table.run(0.5);
    const Real a = 0.1 * g / std::sqrt(1.01);
    EXPECT_NEAR(table.v().x(), 0.5 * a, 1e-6);
    EXPECT_NEAR(table.v().y(), 1, 1e-9);
    EXPECT_NEAR(table.spin(), 5, 1e-9);
  }
}

/// A stage that starts at the end of another has its stretch as it is, whatever the rate of slip.
TEST(Friction, AStageAfterAnEulerStageGoesOnWithItsDrag) {
  const Vec3 n_W = Vec3::UnitZ(), none = Vec3::Zero(), xi_W(4e-4, 2e-4, 0);
  const ContactPlacesOf<Real> at;
  const ContactPastOf<Real> past{.anchors = anchored<Real>(at, none, n_W, xi_W, none),
                                 .n_W = n_W,
                                 .slip_dot_W = Vec3(1, 1, 0),
                                 .e = 0,
                                 .pressed = 0,
                                 .F_n = 1};
  const ContactStartOf<Real> start{.at = at, .n_W = n_W, .v_W = none, .rho = 0, .d_0 = 0, .approach = 0};
  EXPECT_EQ(recalled<Real>({.k = 1000}, {.continues_step = true}, 1e-4, past, start).xi_W, xi_W);
}

}  // namespace
}  // namespace godobject::test_friction
