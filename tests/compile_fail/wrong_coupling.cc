// Must not compile: a feedback is no coupling.
#include "core/godobject.h"

using namespace godobject;

struct Mixed {
  static constexpr int max_bodies = 1;
  using Integrator = TrBdf2;
  using Device = PoseDevice;
  using Coupling = LimitedFeedback;
  using Joints = None;
  using Feedback = None;
};
static_assert(Scene<Mixed>);
