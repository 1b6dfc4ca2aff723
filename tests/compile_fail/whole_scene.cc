// Must compile: shows that the others fail for the reason they name, not for their compiler flags.
#include "core/integrator_tr_bdf2.h"
#include "core/step.h"

struct Haptic {
  static constexpr int max_bodies = 1;
  using Integrator = godobject::TrBdf2;
  using Device = godobject::PoseDevice;
  using Coupling = godobject::DampedSpring;
  using Joints = godobject::None;
  using Feedback = godobject::LimitedFeedback;
};
static_assert(godobject::Scene<Haptic>);
