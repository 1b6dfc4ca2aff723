/* A time of day that a test steps: preloaded into the program, it adds the seconds in the file STEPPED_CLOCK to
 * CLOCK_REALTIME. No other clock is changed. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <time.h>

static const volatile double* step_s;
static int (*real_gettime)(clockid_t, struct timespec*);

__attribute__((constructor)) static void map_step(void) {
  const char* const path = getenv("STEPPED_CLOCK");
  const int file = path ? open(path, O_RDONLY | O_CLOEXEC) : -1;
  void* const page = file < 0 ? MAP_FAILED : mmap(NULL, sizeof(double), PROT_READ, MAP_SHARED, file, 0);
  real_gettime = (int (*)(clockid_t, struct timespec*))dlsym(RTLD_NEXT, "clock_gettime");
  step_s = page == MAP_FAILED ? NULL : page;
}

int clock_gettime(clockid_t clock, struct timespec* now) {
  const int result = real_gettime(clock, now);
  if (clock == CLOCK_REALTIME && step_s) now->tv_sec += (time_t)*step_s;
  return result;
}
