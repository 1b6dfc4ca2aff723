// Another law of contact, in a file that replaces core/contact/law.h: restitution of a ball on a plane.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include "tests/core/one_body.h"

namespace godobject::test_restitution {
namespace {

template <class I>
struct Ball : OneBody<I> {
  using Joints = TreeJoints<>;
  using Contacts = FixedContacts<1, 1, 1>;
};

/// Returns the coefficient of restitution of the law. Speed and compression obey m v dv = -F dd, so that the
/// integrals of v / (1 + alpha v) over both ways, from v and to -e v, are equal:
///
///   alpha v (1 + e) = log((1 + alpha v) / (1 - alpha v e))
///
/// Marhefka and Orin, "A compliant contact model with nonlinear damping for simulation of robotic systems",
/// IEEE Trans. SMC-A 29 (1999).
Real closed_form(Real alpha, Real v) {
  const Real a = alpha * v;
  Real low = 0, high = std::min(1.0, 1 / a);
  for (int k = 0; k < 100; ++k) {
    const Real e = (low + high) / 2;
    (a * (1 + e) > std::log((1 + a) / (1 - a * e)) ? low : high) = e;
  }
  return low;
}

/// Returns the speed at which a ball leaves the plane z = 0 that it meets at speed v, as a share of v. start:
/// height above the plane, as a share of the way in a step.
template <class I>
Real restitution(Real k, Real alpha, Real v, Real h, Real start = 0.3) {
  Running<Ball<I>> run;
  run.par.h = h;
  run.par.bodies[0].body = rigid_body(0.1, Vec3::Constant(1e-5).asDiagonal());
  run.par.contacts.spheres[0] = {.body = 0, .radius = 0.01};
  run.par.contacts.surfaces[0] = {};
  run.par.contacts.num_spheres = run.par.contacts.num_surfaces = 1;
  run.par.contacts.laws[0][0] = {.k = k, .alpha = alpha};
  run.x.bodies[0].x.X_WB.p = Vec3(0, 0, 0.01 + start * h * v);
  run.x.bodies[0].x.v_W = Vec3(0, 0, -v);
  do {
    run.step();
    EXPECT_FALSE(any(run.out.fault));
  } while ((run.body().v_W.z() < 0 || run.out.contacts.num_contacts > 0) && run.x.tick < 100000);
  return run.body().v_W.z() / v;
}

template <class I>
class HuntCrossley : public ::testing::Test {};
using Integrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(HuntCrossley, Integrators);

/// Largest errors seen: 1.2e-2 of implicit Euler, 1.2e-6 of TR-BDF2.
TYPED_TEST(HuntCrossley, RestitutionIsThatOfTheClosedForm) {
  const Real most = TypeParam::order == 1 ? 2e-2 : 3e-6;
  for (const Real k : {1e5, 1e6})
    for (const Real alpha : {0.01, 0.1, 0.5, 2.0})
      for (const Real v : {0.05, 0.5, 2.0})
        EXPECT_NEAR(restitution<TypeParam>(k, alpha, v, 1e-5), closed_form(alpha, v), most)
            << "k " << k << ", alpha " << alpha << ", v " << v;
}

TYPED_TEST(HuntCrossley, RestitutionConvergesInTheOrderOfTheIntegrator) {
  for (const Real alpha : {0.1, 0.5}) {
    const Real v = 1, e = closed_form(alpha, v);
    std::vector<Real> errors;
    for (Real h = 4e-4; h > 1e-5; h /= 2) {
      Real error = 0;
      for (const Real start : {0.1, 0.3, 0.6, 0.9})
        error = std::max(error, std::abs(restitution<TypeParam>(1e5, alpha, v, h, start) - e));
      errors.push_back(error);
      std::printf("%-14s alpha %.1f, h %.4f ms: error %.2e\n", TypeParam::name, alpha, 1e3 * h, error);
    }
    const Real order = std::log2(errors.front() / errors.back()) / static_cast<Real>(errors.size() - 1);
    EXPECT_GT(order, TypeParam::order - 0.1);
  }
}

}  // namespace
}  // namespace godobject::test_restitution
