// Logs as buses: a log is refused with its line, or its frames arrive one after the other.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include "platform/linux/bus/bus.h"
#include "tests/fuzz/decode.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace godobject;
  static const int file = memfd_create("log", 0);
  if (ftruncate(file, 0) != 0 || pwrite(file, data, size, 0) != static_cast<ssize_t>(size)) return 0;
  ReplayBus bus("/proc/self/fd/" + std::to_string(file), {});
  if (!bus.open()) {
    if (bus.trouble().empty()) std::abort();
    return 0;
  }
  ReceivedFrame frame;
  Nanoseconds before = 0;
  for (int i = 0; i < 100 && bus.try_receive(frame); ++i) {
    if (!is_valid(frame.frame) || frame.t_ns < before) std::abort();
    before = frame.t_ns;
  }
  return 0;
}
