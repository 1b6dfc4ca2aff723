#include <sanitizer/allocator_interface.h>

#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/decode.h"

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
