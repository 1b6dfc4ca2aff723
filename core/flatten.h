// A step and all it calls in one function: the chain of its results stays in registers (docs/decisions/010). Builds
// with assertions and sanitizers do without; they would compile for minutes.
#pragma once

#ifdef NDEBUG
#define GODOBJECT_FLATTEN [[gnu::flatten]]
#else
#define GODOBJECT_FLATTEN
#endif
