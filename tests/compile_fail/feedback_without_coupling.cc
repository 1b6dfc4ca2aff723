// Must not compile: nothing pulls the body, so there is nothing to feel.
#include "core/godobject.h"

struct NothingToFeel {
  static constexpr int max_bodies = 1;
  using Integrator = godobject::ImplicitEuler;
  using Device = godobject::PoseDevice;
  using Coupling = godobject::None;
  using Feedback = godobject::LimitedFeedback;
};
static_assert(godobject::Scene<NothingToFeel>);
