// Must not compile: the scene would have no contacts.
#include "core/godobject.h"

using namespace godobject;

struct WithContact {
  static constexpr int max_bodies = 1;
  using Integrator = TrBdf2;
  using Device = None;
  using Coupling = None;
  using Joints = None;
  using Feedback = None;
  using Contact = FixedContacts<10, 1, 20>;
};
static_assert(Scene<WithContact>);
