// Must not compile: a list of terms is no net.
#include "core/godobject.h"

using namespace godobject;

struct Mixed {
  static constexpr int max_bodies = 1;
  using Integrator = TrBdf2;
  using Device = PoseDevice;
  using Coupling = DampedSpring;
  using Joints = None;
  using Feedback = None;
  using Contacts = BodyContacts<10, 1, 20, 20>;
  using Net = TermList<DampedSprings<5>>;
};
static_assert(Scene<Mixed>);
