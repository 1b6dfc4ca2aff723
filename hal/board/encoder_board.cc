#include "hal/board/encoder_board.h"

#include <algorithm>
#include <cmath>

#include "hal/base/crc16.h"

namespace godobject {
namespace {

constexpr std::size_t fixed_size = 10;  // type, sequence, t_us, status, CRC
/// The board's clock has restarted if the time between two frames differs from the host's by more than this,
/// ns.
constexpr Nanoseconds clock_jump = 1'000'000'000;

}  // namespace

std::span<const std::uint8_t> make_encoder_frame(const EncoderFrame& frame,
                                                 std::span<std::uint8_t> out) noexcept {
  if (frame.num_counts > max_board_counts) return {};
  std::array<std::uint8_t, max_encoder_payload> payload{};
  ByteWriter writer(payload);
  writer.put(counts_frame_type).put(frame.sequence).put(frame.t_us);
  for (std::size_t i = 0; i < frame.num_counts; ++i) writer.put(frame.counts[i]);
  writer.put(frame.status);
  const std::span<const std::uint8_t> before_crc(payload.data(), writer.size());
  writer.put(crc16<crc16_ccitt>(before_crc));
  const auto size = cobs_encode({payload.data(), writer.size()}, out);
  return size ? out.first(*size) : std::span<std::uint8_t>{};
}

ParseResult parse_encoder_frame(std::span<const std::uint8_t> payload, EncoderFrame& out) noexcept {
  if (payload.size() < fixed_size) return ParseResult::too_short;
  if (payload.size() > max_encoder_payload) return ParseResult::too_long;
  std::uint16_t crc = 0;
  ByteReader(payload.last(2)).get(crc);
  if (crc != crc16<crc16_ccitt>(payload.first(payload.size() - 2))) return ParseResult::bad_value;
  if (payload[0] != counts_frame_type || (payload.size() - fixed_size) % 4 != 0)
    return ParseResult::other_message;
  EncoderFrame frame{.num_counts = (payload.size() - fixed_size) / 4};
  ByteReader reader(payload.subspan(1));
  reader.get(frame.sequence).get(frame.t_us);
  for (std::size_t i = 0; i < frame.num_counts; ++i) reader.get(frame.counts[i]);
  reader.get(frame.status);
  out = frame;
  return ParseResult::ok;
}

bool EncoderBoard::receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept {
  bool any = false;
  for (const std::uint8_t byte : bytes) {
    switch (decoder_.push(byte)) {
      case CobsDecoder::Result::more: break;
      case CobsDecoder::Result::cut_off:
      case CobsDecoder::Result::too_large: ++counters_.malformed; break;
      case CobsDecoder::Result::frame: {
        EncoderFrame frame;
        const ParseResult result = parse_encoder_frame(decoder_.payload(), frame);
        if (result == ParseResult::ok) {
          take(frame, now);
          any = true;
        } else {
          ++(result == ParseResult::bad_value ? counters_.bad_crc : counters_.malformed);
        }
        break;
      }
    }
  }
  return any;
}

void EncoderBoard::take(const EncoderFrame& frame, Nanoseconds now) noexcept {
  if (counters_.frames > 0) {
    const Nanoseconds board = 1000 * Nanoseconds{static_cast<std::int32_t>(frame.t_us - frame_.t_us)};
    if (std::abs(board - (now - t_arrival_)) > clock_jump) {
      ++counters_.reboots;
      time_us_.reset();
      clock_.reset();
    } else {
      counters_.lost += static_cast<std::uint8_t>(frame.sequence - frame_.sequence - 1);
    }
  }
  const Nanoseconds t_board = 1000 * time_us_.unwrap(frame.t_us);
  clock_.add(t_board, now);
  t_ns_ = std::min(clock_.to_host(t_board), now);
  t_arrival_ = now;
  frame_ = frame;
  ++counters_.frames;
}

}  // namespace godobject
