// Must not compile: a device is no joints.
#include "core/godobject.h"

using namespace godobject;

struct Mixed {
  static constexpr int max_bodies = 1;
  using Integrator = TrBdf2;
  using Device = PoseDevice;
  using Coupling = DampedSpring;
  using Joints = PoseDevice;
  using Feedback = None;
};
static_assert(Scene<Mixed>);
