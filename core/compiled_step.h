// Compiles the step of a scene type in one source file, so that edits of the others do not compile it again.
//
//   extern GODOBJECT_STEP_OF(MyTool);   in the header of the scene type
//   GODOBJECT_STEP_OF(MyTool);          in that source file
//
// Both are at global scope or in the namespace godobject.
#pragma once

#include "core/step.h"

#define GODOBJECT_STEP_OF(...)                                                     \
  template void godobject::step<__VA_ARGS__>(                                      \
      const godobject::Params<__VA_ARGS__>&, const godobject::Input<__VA_ARGS__>&, \
      godobject::State<__VA_ARGS__>&, godobject::Scratch<__VA_ARGS__>&,            \
      godobject::Output<__VA_ARGS__>&) noexcept GODOBJECT_NONBLOCKING
