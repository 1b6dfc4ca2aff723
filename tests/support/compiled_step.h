// The step of a scene that many tests run is compiled in one unit, since it takes g++ ten seconds: others of the same
// program say `extern GODOBJECT_STEP_OF(scene);`, that one without `extern`.
#pragma once

#include "core/step.h"

#define GODOBJECT_STEP_OF(...)                                                           \
  template void step<__VA_ARGS__>(const Params<__VA_ARGS__>&, const Input<__VA_ARGS__>&, \
                                  State<__VA_ARGS__>&, Scratch<__VA_ARGS__>&, Output<__VA_ARGS__>&) noexcept
