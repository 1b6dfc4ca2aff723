// A step and all it calls, but for stages with contacts, in one function: the chain of its results stays in registers
// (docs/decisions/010). Of stages with contacts what begins and carries over four of them, and an island's solution, are one
// function each: they hand each other structs of vectors (docs/decisions/060). Builds with assertions and sanitizers do without,
// and so do the core's own tests, which instantiate it by the dozen: they would compile for minutes.
#pragma once

#if defined(NDEBUG) && !defined(GODOBJECT_NO_FLATTEN)
#define GODOBJECT_FLATTEN [[gnu::flatten]]
#else
#define GODOBJECT_FLATTEN
#endif
