// The scenes of most tests of nets, whose steps are compiled once.
#pragma once

#include "core/compiled_step.h"
#include "tests/core/net/net_scene.h"

namespace godobject {

extern GODOBJECT_STEP_OF(NetScene<ImplicitEuler>);
extern GODOBJECT_STEP_OF(NetScene<TrBdf2>);
extern GODOBJECT_STEP_OF(JointedNetScene<ImplicitEuler>);
extern GODOBJECT_STEP_OF(JointedNetScene<TrBdf2>);
extern GODOBJECT_STEP_OF(AttachedNetScene<ImplicitEuler>);
extern GODOBJECT_STEP_OF(AttachedNetScene<TrBdf2>);

}  // namespace godobject
