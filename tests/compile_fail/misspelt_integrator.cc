// Must not compile: the given type is no integrator.
#include "core/step.h"

struct WithoutIntegrator {
  static constexpr int max_bodies = 1;
  using Integrator = godobject::RigidBodyState;
  using Device = godobject::None;
  using Coupling = godobject::None;
  using Joints = godobject::None;
  using Feedback = godobject::None;
};
static_assert(godobject::Scene<WithoutIntegrator>);
