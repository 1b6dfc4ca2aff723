#include "tests/study/map/scenes.h"

namespace godobject {

GODOBJECT_STEP_OF(OneBody<ImplicitEuler>);
GODOBJECT_STEP_OF(OneBody<TrBdf2>);
GODOBJECT_STEP_OF(study::Mechanism<ImplicitEuler>);
GODOBJECT_STEP_OF(study::Mechanism<TrBdf2>);

}  // namespace godobject
