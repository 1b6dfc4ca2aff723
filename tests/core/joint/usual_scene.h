// The scene of most tests of articulated tools, whose step is compiled once.
#pragma once

#include "core/compiled_step.h"
#include "tests/study/joint/tool.h"

namespace godobject {

extern GODOBJECT_STEP_OF(Articulated<ImplicitEuler>);
extern GODOBJECT_STEP_OF(Articulated<TrBdf2>);

}  // namespace godobject
