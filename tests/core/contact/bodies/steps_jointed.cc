#include "tests/core/contact/bodies/jointed_pile.h"

namespace godobject {

GODOBJECT_STEP_OF(Jointed<ImplicitEuler>);
GODOBJECT_STEP_OF(Jointed<TrBdf2>);

}  // namespace godobject
