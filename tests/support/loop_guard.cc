// Counts heap calls and locks of the loop of `godobject run`: preloaded into the program. The loop is the
// thread that sleeps until absolute times. Its calls count from its 100th sleep to its last one, so its
// set-up and its end do not. At exit a line is appended to the file named by GODOBJECT_LOOP_GUARD.
#include <dlfcn.h>
#include <pthread.h>
#include <time.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

constexpr long first_sleep = 100;

// Plain data of static size, because a thread's first access must not allocate.
thread_local long sleeps = 0, heap_calls = 0, locks = 0;  // heap_calls, locks: since the last sleep
std::atomic<long> all_sleeps{0}, all_heap_calls{0}, all_locks{0};

template <class Function>
Function* next(const char* name) noexcept {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}
auto* const libc_lock = next<int(pthread_mutex_t*)>("pthread_mutex_lock");
auto* const libc_sleep = next<int(clockid_t, int, const timespec*, timespec*)>("clock_nanosleep");

bool is_run() noexcept {
  std::array<char, 4096> arguments{};
  std::FILE* const file = std::fopen("/proc/self/cmdline", "rb");
  if (file == nullptr) return false;
  const std::size_t size = std::fread(arguments.data(), 1, arguments.size() - 1, file);
  std::fclose(file);
  const std::size_t program = std::strlen(arguments.data()) + 1;
  return program < size && std::strcmp(arguments.data() + program, "run") == 0;
}

__attribute__((destructor)) void write_counts() {
  const char* const path = std::getenv("GODOBJECT_LOOP_GUARD");
  if (path == nullptr || all_sleeps == 0 || !is_run()) return;
  if (std::FILE* const file = std::fopen(path, "a")) {
    std::fprintf(file, "%ld %ld %ld\n", all_sleeps.load(), all_heap_calls.load(), all_locks.load());
    std::fclose(file);
  }
}

}  // namespace

// Other names of glibc's allocator, because a look-up with dlsym would allocate.
// NOLINTBEGIN(readability-inconsistent-declaration-parameter-name): the library's own names are reserved.
extern "C" {
// NOLINTBEGIN(bugprone-reserved-identifier, readability-identifier-naming): glibc's
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void __libc_free(void*);
// NOLINTEND(bugprone-reserved-identifier, readability-identifier-naming)

void* malloc(std::size_t size) {
  ++heap_calls;
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  ++heap_calls;
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t size) {
  ++heap_calls;
  return __libc_realloc(p, size);
}
void free(void* p) {
  ++heap_calls;
  __libc_free(p);
}
int pthread_mutex_lock(pthread_mutex_t* mutex) {
  ++locks;
  return libc_lock(mutex);
}
int clock_nanosleep(clockid_t clock, int flags, const timespec* request, timespec* remaining) {
  if ((flags & TIMER_ABSTIME) != 0) {
    if (++sleeps > first_sleep) {
      all_sleeps.fetch_add(1, std::memory_order_relaxed);
      all_heap_calls.fetch_add(heap_calls, std::memory_order_relaxed);
      all_locks.fetch_add(locks, std::memory_order_relaxed);
    }
    heap_calls = locks = 0;
  }
  return libc_sleep(clock, flags, request, remaining);
}
}  // extern "C"
// NOLINTEND(readability-inconsistent-declaration-parameter-name)
