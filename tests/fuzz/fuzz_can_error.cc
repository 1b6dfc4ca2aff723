// Error frames of CAN drivers, one after the other.
#include <cstdlib>

#include "hal/can/error.h"
#include "tests/fuzz/decode.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace godobject;
  fuzz::Input in(data, size);
  const fuzz::NoAllocation guard;
  BusState state = BusState::error_active;
  BusCounters counters;
  while (!in.empty()) {
    const std::uint32_t error_class = in.word() & 0x1FFF'FFFF;
    apply(decode_can_error(error_class, in.bytes(8)), state, counters);
    if (state > BusState::gone || name_of(state).empty() || name_of(counters.last_error).empty())
      std::abort();
  }
  return 0;
}
