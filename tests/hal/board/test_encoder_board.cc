#include "hal/board/encoder_board.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace godobject::test_encoder_board {
namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr Nanoseconds ms = 1'000'000;

Bytes wire_of(const EncoderFrame& frame) {
  std::array<std::uint8_t, max_encoder_wire> buffer{};
  const std::span<const std::uint8_t> bytes = make_encoder_frame(frame, buffer);
  return {bytes.begin(), bytes.end()};
}

EncoderFrame frame_at(int i) {
  EncoderFrame frame{.sequence = static_cast<std::uint8_t>(i), .t_us = static_cast<std::uint32_t>(1000 * i)};
  frame.num_counts = 2;
  frame.counts = {-5 + i, 70'000};
  frame.status = board_status::not_referenced;
  return frame;
}

TEST(EncoderFrame, BytesOnTheWire) {
  // type 01, sequence 07, 00010203h us, counts -1 and 2, status 0001h, CRC; then COBS.
  EncoderFrame frame{.sequence = 7, .t_us = 0x00010203};
  frame.num_counts = 2;
  frame.counts = {-1, 2};
  frame.status = 1;
  const Bytes expected{0x06, 0x01, 0x07, 0x03, 0x02, 0x01, 0x06, 0xFF, 0xFF, 0xFF,
                       0xFF, 0x02, 0x01, 0x01, 0x02, 0x01, 0x03, 0x00, 0x00, 0x00};
  Bytes wire = wire_of(frame);
  ASSERT_EQ(wire.size(), 20u);
  wire[17] = wire[18] = 0;  // the CRC has its own test
  EXPECT_EQ(wire, expected);
}

TEST(EncoderFrame, EverySizeComesBack) {
  for (std::size_t n = 0; n <= max_board_counts; ++n) {
    EncoderFrame frame = frame_at(3);
    frame.num_counts = n;
    for (std::size_t i = 0; i < n; ++i) frame.counts[i] = static_cast<std::int32_t>(0x01000000 * i) - 1;
    CobsDecoder decoder;
    EncoderFrame back;
    for (const std::uint8_t byte : wire_of(frame)) {
      if (decoder.push(byte) == CobsDecoder::Result::frame) {
        ASSERT_EQ(parse_encoder_frame(decoder.payload(), back), ParseResult::ok);
      }
    }
    ASSERT_EQ(back.num_counts, n);
    for (std::size_t i = 0; i < n; ++i) EXPECT_EQ(back.counts[i], frame.counts[i]);
    EXPECT_EQ(back.t_us, frame.t_us);
    EXPECT_EQ(back.status, frame.status);
  }
  EncoderFrame too_many;
  too_many.num_counts = max_board_counts + 1;
  EXPECT_TRUE(wire_of(too_many).empty());
}

TEST(EncoderFrame, PayloadsOfOtherKinds) {
  EncoderFrame frame;
  EXPECT_EQ(parse_encoder_frame({}, frame), ParseResult::too_short);
  EXPECT_EQ(parse_encoder_frame(Bytes(max_encoder_payload + 4), frame), ParseResult::too_long);
  EXPECT_EQ(parse_encoder_frame(Bytes(14), frame), ParseResult::bad_value);
}

TEST(EncoderBoard, CountsWhatIsLost) {
  EncoderBoard board;
  for (int i = 0; i < 600; ++i) {
    if (i % 100 == 50 || i % 100 == 51) continue;
    EXPECT_TRUE(board.receive(wire_of(frame_at(i)), i * ms));
  }
  EXPECT_EQ(board.counters().frames, 588u);
  EXPECT_EQ(board.counters().lost, 12u);
  EXPECT_EQ(board.counters().bad_crc, 0u);
  EXPECT_EQ(board.counters().reboots, 0u);
  EXPECT_EQ(board.frame().counts[0], 594);
}

TEST(EncoderBoard, NoCorruptedFrameIsTaken) {
  std::mt19937 random(1);
  for (std::size_t at = 0; at < wire_of(frame_at(5)).size(); ++at) {
    for (int flip = 1; flip < 256; ++flip) {
      Bytes wire = wire_of(frame_at(5));
      wire[at] = static_cast<std::uint8_t>(wire[at] ^ flip);
      EncoderBoard board;
      EXPECT_FALSE(board.receive(wire, 0)) << at << " ^ " << flip;
      // Reads the next frames; the first one ends the corrupted frame.
      static_cast<void>(board.receive(wire_of(frame_at(6)), ms));
      EXPECT_TRUE(board.receive(wire_of(frame_at(7)), 2 * ms));
      EXPECT_EQ(board.frame().counts[0], 2);
    }
  }
}

TEST(EncoderBoard, TimeIsTheBoardsWithoutTheLinesJitter) {
  EncoderBoard board;
  std::mt19937 random(1);
  std::exponential_distribution<double> jitter(1 / 0.5e6);
  double worst = 0;
  for (int i = 0; i < 10'000; ++i) {
    const Nanoseconds arrival = 1'000'000'000 + i * ms + 400'000 + static_cast<Nanoseconds>(jitter(random));
    ASSERT_TRUE(board.receive(wire_of(frame_at(i)), arrival));
    EXPECT_LE(board.t_ns(), arrival);
    if (i > 2000)
      worst = std::max(worst, std::abs(static_cast<double>(board.t_ns() - (1'000'400'000 + i * ms))));
  }
  EXPECT_LT(worst, 20'000) << "ns; the jitter is 500 us";
}

TEST(EncoderBoard, ARebootIsSeen) {
  EncoderBoard board;
  for (int i = 0; i < 5000; ++i) static_cast<void>(board.receive(wire_of(frame_at(i)), i * ms));
  for (int i = 0; i < 100; ++i) static_cast<void>(board.receive(wire_of(frame_at(i)), (6000 + i) * ms));
  EXPECT_EQ(board.counters().reboots, 1u);
  EXPECT_EQ(board.counters().lost, 0u);
  EXPECT_EQ(board.t_ns(), 6099 * ms);
}

TEST(EncoderBoard, AnyBytesAreSurvived) {
  std::mt19937 random(4);
  EncoderBoard board;
  Bytes noise(100);
  for (int i = 0; i < 20'000; ++i) {
    for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random() % (i % 2 == 0 ? 256 : 6));
    EXPECT_FALSE(board.receive(noise, i)) << "one in 65536 would be";
  }
}

}  // namespace
}  // namespace godobject::test_encoder_board
