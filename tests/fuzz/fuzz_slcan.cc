// SLCAN from both sides: random bytes as lines of an adapter and of a host; a frame that was read is written
// the same.
#include <cstdlib>

#include "hal/can/slcan.h"
#include "tests/fuzz/decode.h"

namespace {

using namespace godobject;

void check_same_again(const CanFrame& frame, const slcan::Reply& reply) {
  std::array<char, slcan::max_line> line;
  const std::size_t length = slcan::format_frame(frame, line, reply.timestamp_ms);
  if (length == 0) std::abort();
  slcan::Reply again;
  if (slcan::parse_reply({line.data(), length - 1}, again) != ParseResult::ok) std::abort();
  if (again.frame.id != frame.id || again.frame.size != frame.size || again.frame.data != frame.data)
    std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const fuzz::NoAllocation guard;
  slcan::LineReader reader;
  for (std::size_t i = 0; i < size; ++i) {
    if (!reader.put(data[i])) continue;
    slcan::Reply reply;
    if (slcan::parse_reply(reader.line(), reply) == ParseResult::ok &&
        reply.kind == slcan::ReplyKind::frame) {
      if (!is_valid(reply.frame)) std::abort();
      check_same_again(reply.frame, reply);
    }
    slcan::Request request;
    if (slcan::parse_request(reader.line(), request) == ParseResult::ok &&
        request.kind == slcan::RequestKind::send && !is_valid(request.frame))
      std::abort();
  }
  return 0;
}
