#include "core/compiled_step.h"
#include "tests/core/net/net_scene.h"

namespace godobject {

GODOBJECT_STEP_OF(NetScene<ImplicitEuler>);
GODOBJECT_STEP_OF(NetScene<TrBdf2>);
GODOBJECT_STEP_OF(JointedNetScene<ImplicitEuler>);
GODOBJECT_STEP_OF(JointedNetScene<TrBdf2>);
GODOBJECT_STEP_OF(AttachedNetScene<ImplicitEuler>);
GODOBJECT_STEP_OF(AttachedNetScene<TrBdf2>);

}  // namespace godobject
