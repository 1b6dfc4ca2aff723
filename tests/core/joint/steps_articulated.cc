#include "core/compiled_step.h"
#include "tests/study/joint/tool.h"

namespace godobject {

GODOBJECT_STEP_OF(Articulated<ImplicitEuler>);
GODOBJECT_STEP_OF(Articulated<TrBdf2>);

}  // namespace godobject
