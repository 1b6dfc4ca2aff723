#include "tests/core/contact/usual_scenes.h"

namespace godobject {

GODOBJECT_STEP_OF(FewBodies<ImplicitEuler>);
GODOBJECT_STEP_OF(FewBodies<TrBdf2>);

}  // namespace godobject
