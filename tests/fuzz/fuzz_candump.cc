// Lines of candump logs: a parsed line is written out and parses to the same again.
#include <array>
#include <cstdlib>
#include <string_view>

#include "hal/can/candump.h"
#include "tests/fuzz/decode.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace godobject;
  const std::string_view line(reinterpret_cast<const char*>(data), size);
  const fuzz::NoAllocation guard;
  ReceivedFrame received, again;
  std::string_view interface, interface_again;
  if (parse_candump(line, received, interface) != CandumpResult::ok) return 0;
  std::array<char, max_candump_line> text;
  std::size_t length = 0;
  if (format_candump(received, interface, text, length) != CandumpResult::ok) std::abort();
  if (parse_candump({text.data(), length}, again, interface_again) != CandumpResult::ok) std::abort();
  // written to the microsecond, read to the nanosecond
  const Nanoseconds written_ns = received.t_ns / 1000 * 1000;
  if (again.t_ns != written_ns || again.frame.id != received.frame.id ||
      again.frame.size != received.frame.size || again.frame.data != received.frame.data)
    std::abort();
  return 0;
}
