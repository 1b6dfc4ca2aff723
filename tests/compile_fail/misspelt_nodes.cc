// Must not compile: the scene would have no nodes.
#include "core/godobject.h"

using namespace godobject;

struct WithNode {
  static constexpr int max_bodies = 1;
  using Integrator = TrBdf2;
  using Device = None;
  using Coupling = None;
  using Joints = None;
  using Feedback = None;
  using Contacts = FixedContacts<10, 1, 20>;
  using nodes = NodeList<5>;
};
static_assert(Scene<WithNode>);
