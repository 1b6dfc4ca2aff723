// Engaging, re-engaging and releasing move nothing and cause no jump.
#include <gtest/gtest.h>

#include "tests/core/one_body.h"

namespace godobject::test_engage {
namespace {

/// Fills in a random sample: poses up to 1 m and half a turn apart from step to step.
void randomise(Random& random, PoseDevice::Input& in) {
  in.target.X_WD = {.p = random.vector(), .q = random.rotation()};
  in.target.V_WD = {.w = random.vector(), .v = random.vector()};
}
void randomise(Random& random, RelativeDevice::Input& in) {
  in.dp_W = 0.01 * random.vector();
  in.dphi_W = random.uniform(0, pi) * random.direction();
  in.clutch = random.integer(0, 1) == 1;
}
void randomise(Random& random, AdmittanceDevice::Input& in) {
  in.F_WB = {.tau = random.vector(), .f = 10 * random.vector()};
}

template <class DevicePart, class IntegratorPart>
struct Kind {
  using Device = DevicePart;
  using Integrator = IntegratorPart;
};

template <class K>
class Engage : public ::testing::Test {
 protected:
  using S = OneBody<typename K::Integrator, typename K::Device, DampedSpring, LimitedFeedback>;
  static constexpr Real h = 1e-3;

  Engage() {
    run_.par.h = h;
    run_.par.gravity_W = Vec3(0, 0, -9.81);
    run_.constants().body = rigid_body(0.2, random_.inertia(Vec3(2e-3, 1e-3, 5e-4)));
    run_.constants().coupling = {.k = 2000, .g = 30, .k_r = 4, .g_r = 0.15};
    run_.constants().feedback.gains = {.k = 1000, .g = 2, .k_r = 2, .g_r = 0.05};
    run_.constants().device.rise = 0.05;
    EXPECT_EQ(validate(run_.par), Invalid::nothing);
    place(run_.x, 0,
          {.X_WB = {.p = random_.vector(), .q = random_.rotation()},
           .V_WB = {.w = 5 * random_.vector(), .v = random_.vector()}});
    run_.device().engaged = false;
  }

  /// One step with a random sample; the shown force keeps its rate limit always.
  void step() {
    randomise(random_, run_.device());
    run_.device().valid = random_.integer(0, 9) > 0;
    const Wrench shown = run_.x.bodies[0].feedback.F_D;
    run_.step();
    const Wrench& F = run_.out.bodies[0].feedback.F_D;
    const FeedbackParams& limits = run_.constants().feedback;
    ASSERT_FALSE(any(run_.out.fault));
    ASSERT_LE((F.f - shown.f).norm(), h * limits.max_force_rate * (1 + 1e-12));
    ASSERT_LE((F.tau - shown.tau).norm(), h * limits.max_torque_rate * (1 + 1e-12));
    ASSERT_LE(F.f.norm(), limits.max_force * (1 + 1e-12));
    ASSERT_LE(F.tau.norm(), limits.max_torque * (1 + 1e-12));
  }

  /// One step after which the body is where its previous velocity, gravity and gyroscopic torque take it.
  void step_as_a_free_body() {
    Running<OneBody<typename K::Integrator, None, None>> free;
    free.par.h = h;
    free.par.gravity_W = run_.par.gravity_W;
    free.constants().body = run_.constants().body;
    free.body() = run_.body();
    free.step();
    const Pose before = run_.body().X_WB;
    const Vec3 v_W = run_.body().v_W;
    step();
    const RigidBodyState &x = run_.body(), &y = free.body();
    EXPECT_LE((x.X_WB.p - before.p - h * v_W).norm(), 1.01 * h * h * run_.par.gravity_W.norm());
    // Gyroscopic torque alone: I w' = -w x I w, I_max / I_min = 4.
    const Real w_sq = y.w_B.squaredNorm();
    EXPECT_LE(x.X_WB.q.angularDistance(y.X_WB.q), 8 * h * h * w_sq + 1e-12);
    EXPECT_LE((x.v_W - y.v_W).norm(), 1e-12 * std::max(1.0, y.v_W.norm()));
    EXPECT_LE((x.w_B - y.w_B).norm(), 1e-2 * h * w_sq + 16 * h * h * w_sq * std::sqrt(w_sq));
  }

  Random random_{11};
  Running<S> run_;
};

using Kinds = ::testing::Types<Kind<PoseDevice, ImplicitEuler>, Kind<PoseDevice, TrBdf2>,
                               Kind<HoldingDevice, ImplicitEuler>, Kind<HoldingDevice, TrBdf2>,
                               Kind<RelativeDevice, ImplicitEuler>, Kind<RelativeDevice, TrBdf2>,
                               Kind<AdmittanceDevice, ImplicitEuler>, Kind<AdmittanceDevice, TrBdf2>>;
TYPED_TEST_SUITE(Engage, Kinds);

TYPED_TEST(Engage, TheFirstStepAfterReleaseIsThatOfAFreeBody) {
  for (int i = 0; i < 50; ++i) this->step();
  this->run_.device().engaged = true;
  this->step_as_a_free_body();
}

TYPED_TEST(Engage, ReEngagingAtRandomTimesIsThatOfAFreeBody) {
  for (int i = 0; i < 100; ++i) {
    this->run_.device().engaged = true;
    this->step_as_a_free_body();
    for (int n = this->random_.integer(0, 120); n > 0; --n) this->step();
    this->run_.device().engaged = false;
    for (int n = this->random_.integer(1, 30); n > 0; --n) this->step();
    if (this->HasFailure()) FAIL() << "in round " << i;
  }
}

TYPED_TEST(Engage, LettingGoIsThatOfAFreeBody) {
  for (int i = 0; i < 100; ++i) {
    this->run_.device().engaged = true;
    for (int n = this->random_.integer(1, 120); n > 0; --n) this->step();
    this->run_.device().engaged = false;
    this->step_as_a_free_body();
    if (this->HasFailure()) FAIL() << "in round " << i;
  }
}

TYPED_TEST(Engage, ShownForceGoesToZeroAfterLettingGo) {
  this->run_.device().engaged = true;
  for (int i = 0; i < 200; ++i) this->step();
  EXPECT_GT(this->run_.out.bodies[0].feedback.F_D.f.norm(), 0.1);
  this->run_.device().engaged = false;
  for (int i = 0; i < 25; ++i) this->step();  // 10 N at 500 N/s, 0.5 N m at 25 N m/s: 20 steps
  EXPECT_EQ(this->run_.out.bodies[0].feedback.F_D.f.norm(), 0);
  EXPECT_EQ(this->run_.out.bodies[0].feedback.F_D.tau.norm(), 0);
}

/// While the ramp rises the force on the body starts from zero and grows with s^2.
TEST(EngageRamp, PullGrowsFromNothing) {
  Running<OneBody<ImplicitEuler>> run;
  run.constants().coupling = {.k = 1000, .g = 60, .k_r = 1, .g_r = 1};
  run.constants().device.rise = 0.1;
  run.device().target.X_WD.p = Vec3(1, 0, 0);
  Real fastest = 0, v_before = 0;
  for (int n = 0; n < 100; ++n) {
    run.step();
    const Real s = n * run.par.h / run.constants().device.rise;
    const Real a = (run.body().v_W.x() - v_before) / run.par.h;
    EXPECT_LE(a, s * s * 1000 * 1.000001 + 1e-12) << n;
    v_before = run.body().v_W.x();
    fastest = std::max(fastest, v_before);
  }
  EXPECT_GT(fastest, 0.1);
}

}  // namespace
}  // namespace godobject::test_engage
