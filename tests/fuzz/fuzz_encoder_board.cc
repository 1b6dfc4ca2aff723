// COBS and the frames of encoder boards, from random bytes at any times; a frame made of them is read back
// the same.
#include <cstdlib>

#include "hal/board/nodes.h"
#include "tests/fuzz/decode.h"

namespace {

using namespace godobject;

void check_same_again(const EncoderFrame& frame) {
  std::array<std::uint8_t, max_encoder_wire> wire;
  const std::span<const std::uint8_t> bytes = make_encoder_frame(frame, wire);
  if (bytes.empty()) std::abort();
  CobsDecoder decoder;
  for (const std::uint8_t byte : bytes)
    if (decoder.push(byte) == CobsDecoder::Result::frame) {
      EncoderFrame again;
      if (parse_encoder_frame(decoder.payload(), again) != ParseResult::ok) std::abort();
      if (again.counts != frame.counts || again.t_us != frame.t_us) std::abort();
      return;
    }
  std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  EncoderBoard board;
  BoardNodes nodes(1e6);
  const fuzz::NoAllocation guard;
  for (Nanoseconds now = 0; !in.empty(); now += Nanoseconds{1000} * in.byte()) {
    if (board.receive(in.bytes(1 + in.byte() % 64), now)) {
      if (board.frame().num_counts > max_board_counts) std::abort();
      check_same_again(board.frame());
    }
    // a whole frame, because random bytes rarely pass the CRC
    EncoderFrame frame{.sequence = in.byte(), .t_us = in.word(), .counts = {}, .num_counts = in.byte() % 13u};
    for (std::size_t i = 0; i < frame.num_counts; ++i) frame.counts[i] = static_cast<std::int32_t>(in.word());
    std::array<std::uint8_t, max_encoder_wire> wire;
    if (in.byte() % 2 == 0) {
      const std::span<const std::uint8_t> bytes = make_encoder_frame(frame, wire);
      board.receive(bytes, now);
      nodes.receive(bytes, now);
    }
    nodes.send(
        in.byte() % 2 == 0 ? canopen::make_sync() : canopen::make_nmt(canopen::NmtCommand::start, in.byte()),
        now);
    ReceivedFrame received;
    while (nodes.try_receive(received, now))
      if (!is_valid(received.frame) || received.t_ns > now) std::abort();
  }
  return 0;
}
