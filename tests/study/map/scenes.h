// Scenes of the stability map that no test of the core shares; their steps are compiled in steps.cc.
#pragma once

#include "core/compiled_step.h"
#include "tests/core/one_body.h"

namespace godobject::study {

/// Up to six coupled bodies on joints that close loops, with springs and gears.
template <class I>
struct Mechanism {
  static constexpr std::size_t max_bodies = 6;
  using Integrator = I;
  using Device = PoseDevice;
  using Joints = TreeJoints<JointStops>;
  using Coupling = DampedSpring;
  using Feedback = None;
  using Contacts = BodyContacts<4, 2, 16>;
  using Terms = TermList<LoopJoints<2>, CoordinateSprings<8>>;
};

}  // namespace godobject::study

namespace godobject {

extern GODOBJECT_STEP_OF(OneBody<ImplicitEuler>);
extern GODOBJECT_STEP_OF(OneBody<TrBdf2>);
extern GODOBJECT_STEP_OF(study::Mechanism<ImplicitEuler>);
extern GODOBJECT_STEP_OF(study::Mechanism<TrBdf2>);

}  // namespace godobject
