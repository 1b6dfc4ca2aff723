// The rule that parameters break comes with the body, sphere or surface that breaks it, and in words.
#include <gtest/gtest.h>

#include <string>

#include "core/godobject.h"

namespace godobject::test_validity {
namespace {

struct Bodies {
  static constexpr std::size_t max_bodies = 20;
  using Integrator = ImplicitEuler;
  using Device = PoseDevice;
  using Coupling = DampedSpring;
  using Joints = TreeJoints<JointStops>;
  using Feedback = None;
  using Contacts = FixedContacts<4, 2, 4>;
};

Params<Bodies> valid() {
  Params<Bodies> par;
  par.num_bodies = 20;
  for (BodyParams<Bodies>& body : par.bodies)
    body.body = rigid_body(0.1, Vec3(1e-4, 1e-4, 1e-4).asDiagonal());
  return par;
}

std::string text_of_broken(const Params<Bodies>& par) { return validate(par).text().data(); }

TEST(Validity, OfValidParametersNamesNoBody) {
  const Validity validity = validate(valid());
  EXPECT_EQ(validity, Invalid::nothing);
  EXPECT_EQ(validity.index, Validity::none);
  EXPECT_STREQ(validity.text().data(), "all parameters are valid");
}

TEST(Validity, NamesTheBodyAndTheReason) {
  for (const std::size_t i : {0u, 7u, 13u, 19u}) {
    const std::string body = "body " + std::to_string(i) + ": ";
    Params<Bodies> par = valid();
    par.bodies[i].body.m = 0;
    EXPECT_EQ(validate(par).index, i);
    EXPECT_EQ(text_of_broken(par), body + "the mass must be finite and above 0 kg");
    par = valid();
    par.bodies[i].body.I_B(0, 0) = -1;
    EXPECT_EQ(text_of_broken(par), body + "the inertia must be symmetric and positive definite");
    par = valid();
    par.bodies[i].coupling.g = -1;
    EXPECT_EQ(text_of_broken(par),
              body + "stiffness, damping, limits and ramp must be finite and at least 0");
    par = valid();
    par.bodies[i].joint.kind = JointKind::hinge;
    par.bodies[i].joint.parent = 19;
    EXPECT_EQ(text_of_broken(par), body + "the joint's parent must be the world or an earlier body");
  }
}

TEST(Validity, NamesTheSphereAndTheSurface) {
  Params<Bodies> par = valid();
  par.contacts.num_spheres = 2;
  par.contacts.spheres[0] = {.body = 0, .p_B = Vec3::Zero(), .radius = 0.01};
  par.contacts.spheres[1] = {.body = 0, .p_B = Vec3::Zero(), .radius = 0};
  EXPECT_EQ(text_of_broken(par).substr(0, 9), "sphere 1:");
  par.contacts.num_spheres = 1;
  par.contacts.num_surfaces = 2;
  par.contacts.surfaces[1].shape.kind = ShapeKind::sphere;
  par.contacts.surfaces[1].shape.radius = -1;
  EXPECT_EQ(text_of_broken(par).substr(0, 10), "surface 1:");
}

TEST(Validity, OfAStepHasNoBody) {
  Params<Bodies> par = valid();
  par.h = 0;
  EXPECT_EQ(text_of_broken(par), "the step h must be finite and above 0 s");
}

TEST(Validity, EveryTextEndsWithinItsRoom) {
  for (int rule = 0; rule <= static_cast<int>(Invalid::not_imposable); ++rule) {
    const Validity longest(Invalid(rule), Validity::none - 1);
    const std::string text = longest.text().data();
    EXPECT_LT(text.size() + 1, longest.text().size()) << text;
    EXPECT_EQ(text.substr(text.size() - std::string(text_of(Invalid(rule))).size()), text_of(Invalid(rule)));
  }
}

/// A body whose device has never had a valid sample rests at its own place, not at the world's origin.
TEST(Placed, WithoutASampleTheTargetIsWhereTheBodyIs) {
  State<Bodies> x;
  place(x, 3, {.X_WB = {.p = Vec3(1, 2, 3), .q = Quat::Identity()}, .V_WB = {}});
  EXPECT_EQ(x.bodies[3].device.last.X_WD.p, Vec3(1, 2, 3));
}

}  // namespace
}  // namespace godobject::test_validity
