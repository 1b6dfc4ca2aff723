#include "tests/support/allocation_guard.h"

#include <dlfcn.h>
#include <pthread.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <cstdlib>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define GODOBJECT_LIBC_IS_TAKEN 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define GODOBJECT_LIBC_IS_TAKEN 1
#endif
#endif

namespace godobject {
namespace {

enum Watched {
  call_malloc,
  call_calloc,
  call_realloc,
  call_free,
  call_posix_memalign,
  call_aligned_alloc,
  call_mutex_lock,
  call_write,
  call_read,
  call_nanosleep,
  call_clock_nanosleep,
  call_clock_gettime,
  num_watched
};
constexpr std::array<const char*, num_watched> names{"malloc",
                                                     "calloc",
                                                     "realloc",
                                                     "free",
                                                     "posix_memalign",
                                                     "aligned_alloc",
                                                     "pthread_mutex_lock",
                                                     "write",
                                                     "read",
                                                     "nanosleep",
                                                     "clock_nanosleep",
                                                     "clock_gettime"};

// Plain data of static size, because a thread's first access must not allocate.
thread_local bool armed = false;
thread_local std::array<long, num_watched> counts{};

}  // namespace

AllocationGuard::AllocationGuard() noexcept {
  counts.fill(0);
  armed = true;
}
AllocationGuard::~AllocationGuard() { armed = false; }

void AllocationGuard::disarm() noexcept { armed = false; }

long AllocationGuard::calls() const noexcept {
  long sum = 0;
  for (const long count : counts) sum += count;
  return sum;
}

long AllocationGuard::heap_calls() const noexcept {
  long sum = 0;
  for (std::size_t i = call_malloc; i <= call_aligned_alloc; ++i) sum += counts[i];
  return sum;
}

std::string AllocationGuard::report() {
  disarm();
  std::string text;
  for (std::size_t i = 0; i < num_watched; ++i)
    if (counts[i] > 0) text += std::string(names[i]) + " x " + std::to_string(counts[i]) + "  ";
  return text;
}

#ifdef GODOBJECT_LIBC_IS_TAKEN
bool AllocationGuard::works() noexcept { return false; }
}  // namespace godobject
#else
bool AllocationGuard::works() noexcept { return true; }

namespace {
void count(Watched call) noexcept {
  if (armed) ++counts[call];
}

/// Returns libc's function, which ours of the same name hides.
template <class Function>
Function* next(const char* name) noexcept {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}
}  // namespace
}  // namespace godobject

using namespace godobject;

// Other names of glibc's allocator, because a look-up with dlsym would allocate. operator new and delete of
// libstdc++ also end here.
// NOLINTBEGIN(readability-inconsistent-declaration-parameter-name): the library's own names are reserved.
extern "C" {
// NOLINTBEGIN(bugprone-reserved-identifier, readability-identifier-naming): glibc's
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);
// NOLINTEND(bugprone-reserved-identifier, readability-identifier-naming)

void* malloc(std::size_t size) {
  count(call_malloc);
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  count(call_calloc);
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t size) {
  count(call_realloc);
  return __libc_realloc(p, size);
}
void free(void* p) {
  count(call_free);
  __libc_free(p);
}
int posix_memalign(void** p, std::size_t alignment, std::size_t size) {
  count(call_posix_memalign);
  *p = __libc_memalign(alignment, size);
  return *p ? 0 : 12;  // ENOMEM
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count(call_aligned_alloc);
  return __libc_memalign(alignment, size);
}

int pthread_mutex_lock(pthread_mutex_t* mutex) {
  count(call_mutex_lock);
  static auto* const libc = next<int(pthread_mutex_t*)>("pthread_mutex_lock");
  return libc(mutex);
}
ssize_t write(int fd, const void* data, std::size_t size) {
  count(call_write);
  static auto* const libc = next<ssize_t(int, const void*, std::size_t)>("write");
  return libc(fd, data, size);
}
ssize_t read(int fd, void* data, std::size_t size) {
  count(call_read);
  static auto* const libc = next<ssize_t(int, void*, std::size_t)>("read");
  return libc(fd, data, size);
}
int nanosleep(const timespec* request, timespec* remaining) {
  count(call_nanosleep);
  static auto* const libc = next<int(const timespec*, timespec*)>("nanosleep");
  return libc(request, remaining);
}
int clock_nanosleep(clockid_t clock, int flags, const timespec* request, timespec* remaining) {
  count(call_clock_nanosleep);
  static auto* const libc = next<int(clockid_t, int, const timespec*, timespec*)>("clock_nanosleep");
  return libc(clock, flags, request, remaining);
}
int clock_gettime(clockid_t clock, timespec* time) noexcept {
  count(call_clock_gettime);
  static auto* const libc = next<int(clockid_t, timespec*)>("clock_gettime");
  return libc(clock, time);
}
}  // extern "C"
   // NOLINTEND(readability-inconsistent-declaration-parameter-name)
#endif
