// Unused parts of a scene have no storage.
#include <gtest/gtest.h>

#include "tests/core/one_body.h"

namespace godobject::test_composition {
namespace {

using FreeEuler = OneBody<ImplicitEuler, None, None, None>;
using FreeTrBdf2 = OneBody<TrBdf2, None, None, None>;
using Coupled = OneBody<ImplicitEuler, PoseDevice, DampedSpring, None>;
using Haptic = OneBody<ImplicitEuler, PoseDevice, DampedSpring, LimitedFeedback>;
using Pushed = OneBody<ImplicitEuler, AdmittanceDevice, None, None>;

// A free body is a rigid body and nothing else.
static_assert(sizeof(BodyState<FreeEuler>) == sizeof(RigidBodyState));
static_assert(sizeof(BodyParams<FreeEuler>) == sizeof(RigidBodyParams));
static_assert(sizeof(State<FreeEuler>) == sizeof(RigidBodyState) + sizeof(std::uint64_t));
static_assert(sizeof(BodyOutput<FreeEuler>) == sizeof(Pose) + sizeof(Twist));

// Each part adds its own size and no more.
static_assert(sizeof(BodyState<FreeTrBdf2>) == sizeof(BodyState<FreeEuler>) + sizeof(TrBdf2::Memory));
static_assert(sizeof(BodyState<Coupled>) ==
              sizeof(BodyState<FreeEuler>) + sizeof(PoseDevice::State) + sizeof(DampedSpring::State));
static_assert(sizeof(BodyState<Haptic>) == sizeof(BodyState<Coupled>) + sizeof(LimitedFeedback::State));
static_assert(sizeof(BodyState<Pushed>) == sizeof(BodyState<FreeEuler>) + sizeof(AdmittanceDevice::State));
static_assert(sizeof(BodyParams<Haptic>) == sizeof(BodyParams<Coupled>) + sizeof(FeedbackParams));
static_assert(sizeof(Input<FreeEuler>) < sizeof(Input<Coupled>));

// The rules of composition (their messages: tests/compile_fail).
static_assert(Scene<FreeEuler> && Scene<FreeTrBdf2> && Scene<Coupled> && Scene<Haptic> && Scene<Pushed>);
static_assert(!Scene<OneBody<ImplicitEuler, PoseDevice, None, LimitedFeedback>>);
static_assert(!Scene<OneBody<ImplicitEuler, None, DampedSpring, None>>);

/// Parts left out do not change the others: feedback does not move the body.
TEST(Composition, FeedbackDoesNotTouchTheMotion) {
  Running<Coupled> coupled;
  Running<Haptic> haptic;
  coupled.constants().coupling = haptic.constants().coupling = {.k = 2000, .g = 60, .k_r = 4, .g_r = 0.15};
  haptic.constants().feedback.gains = {.k = 1000, .g = 2, .k_r = 2, .g_r = 0.05};
  for (int n = 0; n < 1000; ++n) {
    coupled.device().target.X_WD.p = haptic.device().target.X_WD.p = Vec3(1e-3 * n, 0, 0);
    coupled.step();
    haptic.step();
  }
  EXPECT_EQ(coupled.body().X_WB.p, haptic.body().X_WB.p);
  EXPECT_EQ(coupled.body().w_B, haptic.body().w_B);
}

}  // namespace
}  // namespace godobject::test_composition
