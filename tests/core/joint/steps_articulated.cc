#include "tests/study/joint/tool.h"
#include "tests/support/compiled_step.h"

namespace godobject {

GODOBJECT_STEP_OF(Articulated<ImplicitEuler>);
GODOBJECT_STEP_OF(Articulated<TrBdf2>);

}  // namespace godobject
