// Articulated tools on obstacles: random bodies, joints, spheres and laws.
#include <gtest/gtest.h>

#include <cstdio>
#include <span>

#include "tests/core/contact/contact_scene.h"
#include "tests/core/joint/random_tool.h"

namespace godobject::test_contact_tools {
namespace {

template <class I>
using Tool = Running<Touching<I, 5, 10, PoseDevice, 2>>;

/// Spheres anywhere on the bodies, over a plane and a box.
template <class I>
void add_random_contacts(Tool<I>& run, Real size, Random& random) {
  auto& par = run.par;
  for (std::size_t i = 0; i < par.num_bodies; ++i)
    for (int s = 0; s < 2; ++s)
      add_sphere(par, i, size * random.uniform(0, 0.5) * random.direction(),
                 size * random.log_uniform(0.02, 0.3));
  Real lowest = 0;
  for (const BodySphere& s : std::span(par.contacts.spheres).first(par.contacts.num_spheres)) {
    const Pose& X = run.x.bodies[s.body].x.X_WB;
    lowest = std::min(lowest, (X.p + X.q * s.p_B).z() - s.radius);
  }
  add_plane(par, {.p = Vec3(0, 0, lowest), .q = exp_so3(Vec3(Vec3::Zero()))});
  add_box(par, {.p = Vec3(0, 0, lowest), .q = random.rotation()}, 0.1 * size * Vec3(1, 2, 3));
  const Real k = random.log_uniform(1e2, 1e9), c = random.log_uniform(1e-2, 10) * 2 * std::sqrt(k);
  set_law(par, {.k = k, .c = c, .mu = random.uniform(0, 1), .k_t = k, .c_t = c, .push_out = 0});
}

template <class I>
class ContactTools : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(ContactTools, BothIntegrators);

/// Pulled into obstacles, in which some begin. Their rest penetration is not relaxed: that would be work.
TYPED_TEST(ContactTools, RandomToolsOnObstaclesGainNothing) {
  Random random(5);
  int touched = 0;
  Real worst = 0;
  for (int n = 0; n < 400; ++n) {
    Tool<TypeParam> run;
    run.par.h = random.log_uniform(1e-4, 5e-3);
    run.par.gravity_W = Vec3(0, 0, -9.81);
    run.par.num_bodies = static_cast<std::size_t>(random.integer(1, 5));
    constexpr Real size = 0.1;
    const Real k = random.log_uniform(10, 1e4);
    for (std::size_t i = 0; i < run.par.num_bodies; ++i) {
      add_random_body(run.par, i, size, random);
      const RigidBodyParams& body = run.par.bodies[i].body;
      run.par.bodies[i].coupling = spring(body, k, k * principal_moments(body.I_B).z() / body.m);
    }
    place_randomly(run.par, run.x, size, 0, random);
    add_random_contacts(run, size, random);
    for (std::size_t i = 0; i < run.par.num_bodies; ++i) {
      Target target{.X_WD = run.x.bodies[i].x.X_WB, .V_WD = {}};
      target.X_WD.p += size * Vec3(0.3 * random.normal(), 0.3 * random.normal(), -0.5);
      engage_at(run.x, i, target);
      run.in.devices[i].target.X_WD = target.X_WD;
    }
    ASSERT_EQ(validate(run.par), Invalid::nothing);
    const Real first = energy(run.par, run.x);
    // the zeros of gravity and springs are not the lowest: available energy
    Real available = 0;
    for (std::size_t i = 0; i < run.par.num_bodies; ++i)
      available += run.par.bodies[i].body.m * 9.81 * size + coupling_at(run.par, run.x, i).energy;
    for (int step = 0; step < 300; ++step) {
      run.step();
      ASSERT_FALSE(any(run.out.fault)) << "case " << n << ", step " << step;
      touched += run.out.contacts.num_contacts > 0 ? 1 : 0;
      const Real gained = (energy(run.par, run.x) - first) / available;
      worst = std::max(worst, gained);
      ASSERT_LT(gained, 1e-9) << TypeParam::name << ", case " << n << ", step " << step;
    }
  }
  EXPECT_GT(touched, 10000);
  std::printf("%s: %d steps with contacts, energy gained at most %.1e of what there was\n", TypeParam::name,
              touched, worst);
}

}  // namespace
}  // namespace godobject::test_contact_tools
