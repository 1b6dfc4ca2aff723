#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/decode.h"

// Declared in <sanitizer/allocator_interface.h>, a header of clang alone.
// NOLINTNEXTLINE(bugprone-reserved-identifier,readability-identifier-naming): the name is the sanitizer's.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void*, std::size_t),
                                                         void (*on_free)(const volatile void*));

namespace godobject::fuzz {
namespace {

thread_local bool armed = false;

void on_allocation(const volatile void*, std::size_t size) {
  if (!armed) return;
  armed = false;
  std::fprintf(stderr, "allocation of %zu bytes in a decoder\n", size);
  std::abort();
}

const bool hooks_installed =
    __sanitizer_install_malloc_and_free_hooks(&on_allocation, [](const volatile void*) {}) != 0;

}  // namespace

NoAllocation::NoAllocation() noexcept { armed = hooks_installed; }
NoAllocation::~NoAllocation() { armed = false; }

}  // namespace godobject::fuzz
