// Scenes of most tests of contacts: one tool on obstacles, and a few bodies among each other. Another
// capacity would be another step to compile.
#pragma once

#include "core/compiled_step.h"
#include "tests/core/contact/bodies/bricks.h"

namespace godobject {

/// A body of up to 12 spheres, each on up to two obstacles.
template <class I>
using OneTool = Touching<I, 1, 12>;

/// Up to eight bodies.
template <class I>
using FewBodies = TouchingBodies<I, 8>;

extern GODOBJECT_STEP_OF(OneTool<ImplicitEuler>);
extern GODOBJECT_STEP_OF(OneTool<TrBdf2>);
extern GODOBJECT_STEP_OF(FewBodies<ImplicitEuler>);
extern GODOBJECT_STEP_OF(FewBodies<TrBdf2>);

}  // namespace godobject
