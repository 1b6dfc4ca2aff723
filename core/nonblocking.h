// Attribute of functions that run in the real-time cycle: they neither block nor allocate nor throw.
// clang 20 and later prove this through all their callees with -Wfunction-effects; tests/nonblocking does so.
// Functions whose definition the compiler sees need no attribute. Virtual functions and those defined in
// another translation unit need one.
#pragma once

#if defined(__has_cpp_attribute)
#if __has_cpp_attribute(clang::nonblocking)
#define GODOBJECT_NONBLOCKING [[clang::nonblocking]]
#endif
#endif
#ifndef GODOBJECT_NONBLOCKING
#define GODOBJECT_NONBLOCKING
#endif
