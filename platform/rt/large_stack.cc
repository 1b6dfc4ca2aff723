#include "platform/rt/large_stack.h"

#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <ucontext.h>
#include <unistd.h>

#include <cstddef>

namespace godobject {
namespace {

constexpr std::size_t stack_bytes = std::size_t{8} << 20;  // Linux' usual limit

bool is_small(const rlimit& limit) noexcept {
  return limit.rlim_cur != RLIM_INFINITY && limit.rlim_cur < stack_bytes;
}

void give_threads_as_much() noexcept {
  pthread_attr_t attributes;
  if (pthread_attr_init(&attributes) != 0) return;
  if (pthread_attr_setstacksize(&attributes, stack_bytes) == 0) pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
}

const std::function<void()>* called = nullptr;  // global, because makecontext() passes no pointers

void enter() { (*called)(); }

}  // namespace

bool call_on_large_stack(const std::function<void()>& f) {
  rlimit limit{};
  if (getrlimit(RLIMIT_STACK, &limit) != 0 || !is_small(limit)) {
    f();
    return true;
  }
  give_threads_as_much();
  const auto guard_bytes = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::size_t bytes = stack_bytes + guard_bytes;
  void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_STACK, -1, 0);
  if (memory == MAP_FAILED) return false;
  mprotect(memory, guard_bytes, PROT_NONE);  // turns an overflow into a SIGSEGV
  ucontext_t caller{}, context{};
  getcontext(&context);
  context.uc_stack.ss_sp = static_cast<std::byte*>(memory) + guard_bytes;
  context.uc_stack.ss_size = stack_bytes;
  context.uc_link = &caller;
  called = &f;
  makecontext(&context, enter, 0);
  swapcontext(&caller, &context);
  munmap(memory, bytes);
  return true;
}

}  // namespace godobject
