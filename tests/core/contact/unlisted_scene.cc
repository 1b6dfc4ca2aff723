// The step of one scene, for unlisted_parts.py to look at: PROBED names it.
#include "core/godobject.h"

namespace godobject {

struct Untouched {
  static constexpr std::size_t max_bodies = 3;
  using Integrator = TrBdf2;
  using Device = PoseDevice;
  using Joints = TreeJoints<JointStops, PrescribedJoints>;
  using Coupling = DampedSpring;
  using Feedback = LimitedFeedback;
};
struct OverObstacles : Untouched {
  using Contacts = FixedContacts<6, 2, 6>;
};
struct AmongBodies : Untouched {
  using Joints = None;
  using Feedback = None;
  using Contacts = BodyContacts<6, 4, 12>;
};
struct OfANet : AmongBodies {
  using Net = MassSpringNet<8, 12, 8>;
};

template void step(const Params<PROBED>&, const Input<PROBED>&, State<PROBED>&, Scratch<PROBED>&,
                   Output<PROBED>&) noexcept GODOBJECT_NONBLOCKING;

}  // namespace godobject
