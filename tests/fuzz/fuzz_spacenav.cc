// Events of spacenavd from random bytes: accepted events are within their bounds.
#include <cstdlib>

#include "hal/tracker/spacenav.h"
#include "tests/fuzz/decode.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace godobject;
  const fuzz::NoAllocation guard;
  SpacenavEvent event;
  if (decode({data, size}, event) != ParseResult::ok) return 0;
  for (const std::int32_t counts : event.axes)
    if (counts < -max_spacenav_counts || counts > max_spacenav_counts) std::abort();
  if (event.button < 0 || event.button > max_spacenav_button) std::abort();
  return 0;
}
