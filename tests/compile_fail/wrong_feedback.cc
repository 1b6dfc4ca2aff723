// Must not compile: a spring is no feedback.
#include "core/godobject.h"

using namespace godobject;

struct Mixed {
  static constexpr int max_bodies = 1;
  using Integrator = TrBdf2;
  using Device = PoseDevice;
  using Coupling = DampedSpring;
  using Joints = None;
  using Feedback = DampedSpring;
};
static_assert(Scene<Mixed>);
