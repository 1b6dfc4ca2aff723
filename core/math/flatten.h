// Attribute that compiles a step and all its callees into one function, except stages with contacts. Its
// chain of results then stays in registers (docs/decisions/010). In stages with contacts, the start and the
// end of four contacts are one function each, and so is the solution of an island. Between them, structs of
// vectors are exchanged (docs/decisions/060). Builds with assertions or sanitizers omit the attribute. So do
// the core's own tests, which instantiate many steps and would compile for minutes.
#pragma once

#if defined(NDEBUG) && !defined(GODOBJECT_NO_FLATTEN)
#define GODOBJECT_FLATTEN [[gnu::flatten]]
#else
#define GODOBJECT_FLATTEN
#endif
