// The step of a scene used by many tests is compiled in one unit, because it takes g++ ten seconds. Other
// units of the program declare `extern GODOBJECT_STEP_OF(scene);`, that unit declares it without `extern`.
#pragma once

#include "core/step.h"

#define GODOBJECT_STEP_OF(...)                                                           \
  template void step<__VA_ARGS__>(const Params<__VA_ARGS__>&, const Input<__VA_ARGS__>&, \
                                  State<__VA_ARGS__>&, Scratch<__VA_ARGS__>&,            \
                                  Output<__VA_ARGS__>&) noexcept GODOBJECT_NONBLOCKING
