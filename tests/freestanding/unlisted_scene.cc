// The step of one scene for unlisted_parts.py, which compiles it for each: PROBED is the name of its type.
#include "core/godobject.h"

namespace godobject {

struct Bare {
  static constexpr std::size_t max_bodies = 3;
  using Integrator = ImplicitEuler;
  using Device = None;
  using Joints = None;
  using Coupling = None;
  using Feedback = None;
};
struct Articulated : Bare {
  using Integrator = TrBdf2;
  using Device = PoseDevice;
  using Joints = TreeJoints<JointStops, PrescribedJoints>;
  using Coupling = DampedSpring;
  using Feedback = LimitedFeedback;
};
struct OverObstacles : Bare {
  using Device = AdmittanceDevice;
  using Joints = TreeJoints<>;
  using Contacts = FixedContacts<6, 2, 6>;
};
struct AmongBodies : Bare {
  using Integrator = TrBdf2;
  using Contacts = BodyContacts<6, 4, 12>;
};
struct OfNets : Bare {
  using Contacts = BodyContacts<6, 4, 12>;
  using Net = MassSpringNet<8, 12, 8, 0, 4>;
};
struct OfNearlyAll : Articulated {
  using Device = RelativeDevice;
  using Contacts = BodyContacts<6, 4, 12>;
  using Terms = TermList<DampedSprings<1>, CoordinateSprings<1>, LoopJoints<1>, ConstantForces<1>>;
  using Net = MassSpringNet<8, 12, 8, 4>;
};

template void step(const Params<PROBED>&, const Input<PROBED>&, State<PROBED>&, Scratch<PROBED>&,
                   Output<PROBED>&) noexcept GODOBJECT_NONBLOCKING;

}  // namespace godobject
