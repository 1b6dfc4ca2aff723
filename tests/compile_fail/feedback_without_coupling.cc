// Must not compile: nothing pulls the body, so there is nothing to feel.
#include "core/integrator_implicit_euler.h"
#include "core/step.h"

struct NothingToFeel {
  static constexpr int max_bodies = 1;
  using Integrator = godobject::ImplicitEuler;
  using Device = godobject::PoseDevice;
  using Coupling = godobject::None;
  using Joints = godobject::None;
  using Feedback = godobject::LimitedFeedback;
};
static_assert(godobject::Scene<NothingToFeel>);
