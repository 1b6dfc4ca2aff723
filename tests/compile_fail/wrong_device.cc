// Must not compile: a spring is no device.
#include "core/godobject.h"

using namespace godobject;

struct Mixed {
  static constexpr int max_bodies = 1;
  using Integrator = TrBdf2;
  using Device = DampedSpring;
  using Coupling = DampedSpring;
  using Joints = None;
  using Feedback = None;
};
static_assert(Scene<Mixed>);
