// Ends a program that starts a thread: preloaded into the test programs that start none.
#include <pthread.h>
#include <unistd.h>

// NOLINTNEXTLINE(readability-inconsistent-declaration-parameter-name): reserved names of the library
extern "C" int pthread_create(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*) {
  constexpr char text[] =
      "thread_guard: this test starts a thread: list its file under THREADS or PROGRAMS in "
      "tests/CMakeLists.txt\n";
  const bool is_written = write(STDERR_FILENO, text, sizeof(text) - 1) > 0;
  _exit(is_written ? 1 : 2);
}
