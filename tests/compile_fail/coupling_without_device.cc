// Must not compile: a coupling to no device.
#include "core/integrator_tr_bdf2.h"
#include "core/step.h"

struct PulledByNobody {
  static constexpr int max_bodies = 1;
  using Integrator = godobject::TrBdf2;
  using Device = godobject::None;
  using Coupling = godobject::DampedSpring;
  using Joints = godobject::None;
  using Feedback = godobject::None;
};
static_assert(godobject::Scene<PulledByNobody>);
