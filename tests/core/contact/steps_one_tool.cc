#include "tests/core/contact/usual_scenes.h"

namespace godobject {

GODOBJECT_STEP_OF(OneTool<ImplicitEuler>);
GODOBJECT_STEP_OF(OneTool<TrBdf2>);

}  // namespace godobject
