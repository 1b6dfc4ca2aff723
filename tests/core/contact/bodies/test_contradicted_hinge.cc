// A body on a hinge rests where its coupling has the least energy, although the target is turned across the
// hinge. The torque of the coupling is then far from the axis.
#include <memory>

#include <gtest/gtest.h>

#include "tests/core/contact/bodies/jointed_pile.h"

namespace godobject::test_contradicted_hinge {
namespace {

template <class I>
class ContradictedHinge : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(ContradictedHinge, BothIntegrators);

TYPED_TEST(ContradictedHinge, RestsAtTheLeastEnergy) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    Random random(seed);
    const auto run = std::make_unique<Running<Jointed<TypeParam>>>();
    auto& par = run->par;
    par.num_bodies = 1;
    par.h = random.log_uniform(1e-4, 5e-3);
    const Real moment = random.log_uniform(1e-6, 1e-3);
    auto& body = par.bodies[0];
    body.body = rigid_body(0.1, random.inertia(moment * Vec3(1, random.uniform(0.5, 1), 0.6)));
    // h^2 k_r: 0.01 to 100 times the moment
    body.coupling = {
        .k = 0, .g = 0, .k_r = moment * random.log_uniform(0.01, 100) / (par.h * par.h), .g_r = 0};
    body.device.rise = 0;
    body.joint.kind = JointKind::hinge;
    body.joint.parent = world;
    const Quat q = random.rotation();
    place(run->x, 0, {.X_WB = {.p = Vec3::Zero(), .q = q}, .V_WB = {}});
    body.joint.P.R = q.toRotationMatrix();
    const Real way = random.uniform(-pi, pi);
    const Vec3 phi_B = random.uniform(0.5, 2.2) * Vec3(std::cos(way), std::sin(way), 0);  // across the hinge
    const Target target{.X_WD = {.p = Vec3::Zero(), .q = (q * exp_so3(phi_B)).normalized()}, .V_WD = {}};
    engage_at<Jointed<TypeParam>>(run->x, 0, target);
    run->in.devices[0].target = target;
    for (auto& device : run->in.devices) device.engaged = device.valid = true;
    ASSERT_EQ(validate(par), Invalid::nothing);
    const Real E_0 = run->energy();
    Real most = 0;
    for (int n = 0; n < 500; ++n) {
      run->step();
      most = std::max(most, run->energy());
    }
    EXPECT_EQ(run->out.fault, Fault::none);
    EXPECT_LE(most, E_0 * (1 + 1e-9));
    EXPECT_LT((q.conjugate() * run->body().X_WB.q).vec().norm(), 1e-6);
  }
}

}  // namespace
}  // namespace godobject::test_contradicted_hinge
