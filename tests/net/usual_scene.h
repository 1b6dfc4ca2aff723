// The scene of most tests of nets, whose step is compiled once.
#pragma once

#include "tests/net/net_scene.h"
#include "tests/support/compiled_step.h"

namespace godobject {

extern GODOBJECT_STEP_OF(NetScene<ImplicitEuler>);
extern GODOBJECT_STEP_OF(NetScene<TrBdf2>);

}  // namespace godobject
