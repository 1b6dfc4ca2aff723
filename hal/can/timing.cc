#include "hal/can/timing.h"

#include <cmath>

namespace godobject {
namespace {

// Classic format: bits subject to stuffing besides the data (start of frame to end of CRC). The fixed tail
// consists of CRC delimiter, acknowledge slot and delimiter, end of frame, intermission.
constexpr int classic_stuffed_overhead(bool extended) { return extended ? 54 : 34; }
constexpr int crc_delimiter_bits = 1;
constexpr int acknowledge_slot_bits = 1;
constexpr int classic_tail_bits = crc_delimiter_bits + acknowledge_slot_bits + acknowledge_delimiter_bits +
                                  end_of_frame_bits + intermission_bits;

int classic_data_bytes(const CanFrame& frame) { return frame.remote ? 0 : frame.size; }

/// Counts the bits of the stuffed part of a classic frame, most significant bit first.
class StuffedBits {
 public:
  void send(std::uint32_t value, int width) {
    for (int i = width - 1; i >= 0; --i) {
      const bool bit = ((value >> i) & 1u) != 0;
      update_crc(bit);
      put(bit);
    }
  }

  void send_crc() {
    const std::uint32_t crc = crc_;
    send(crc, 15);
  }

  int count() const { return count_; }

 private:
  // Polynomial x^15 + x^14 + x^10 + x^8 + x^7 + x^4 + x^3 + 1 (ISO 11898-1), over the bits before stuffing.
  void update_crc(bool bit) {
    const bool feedback = bit != (((crc_ >> 14) & 1u) != 0);
    crc_ = (crc_ << 1) & 0x7FFFu;
    if (feedback) crc_ ^= 0x4599u;
  }

  // Adds a bit. After five equal bits a complementary stuff bit follows and begins the next run.
  void put(bool bit) {
    run_ = (count_ > 0 && bit == last_) ? run_ + 1 : 1;
    last_ = bit;
    ++count_;
    if (run_ == 5) {
      last_ = !bit;
      run_ = 1;
      ++count_;
    }
  }

  int count_ = 0;
  int run_ = 0;
  bool last_ = false;
  std::uint32_t crc_ = 0;
};

int exact_classic_bits(const CanFrame& frame) {
  StuffedBits bits;
  bits.send(0, 1);  // start of frame
  if (frame.extended) {
    bits.send(frame.id >> 18, 11);
    bits.send(0b11, 2);  // SRR, IDE
    bits.send(frame.id & 0x3FFFFu, 18);
    bits.send(frame.remote ? 1 : 0, 1);
    bits.send(0, 2);  // r1, r0
  } else {
    bits.send(frame.id, 11);
    bits.send(frame.remote ? 1 : 0, 1);
    bits.send(0, 2);  // IDE, r0
  }
  bits.send(frame.size, 4);
  for (int i = 0; i < classic_data_bytes(frame); ++i) bits.send(frame.data[static_cast<std::size_t>(i)], 8);
  bits.send_crc();
  return bits.count() + classic_tail_bits;
}

// FD: bits at the nominal rate are the head up to BRS and the tail from the CRC delimiter. At the data rate
// are ESI, DLC, data, stuff count, and the CRC of 17 or 21 bits with fixed stuff bits.
FrameBits fd_bits(const CanFrame& frame, bool worst) {
  const int head = frame.extended ? 36 : 17;
  const int n = frame.size;
  FrameBits bits{.nominal_rate = frame.extended ? 49 : 30, .data_rate = 5 + 8 * n + (n <= 16 ? 27 : 32)};
  if (worst) {
    bits.nominal_rate += (head - 1) / 4;
    bits.data_rate += (5 + 8 * n) / 4;
  }
  if (!frame.bit_rate_switch) bits = {.nominal_rate = bits.total(), .data_rate = 0};
  return bits;
}

}  // namespace

FrameBits nominal_bits(const CanFrame& frame) noexcept {
  if (frame.fd) return fd_bits(frame, false);
  return {.nominal_rate =
              classic_stuffed_overhead(frame.extended) + 8 * classic_data_bytes(frame) + classic_tail_bits};
}

FrameBits worst_bits(const CanFrame& frame) noexcept {
  if (frame.fd) return fd_bits(frame, true);
  const int stuffed = classic_stuffed_overhead(frame.extended) + 8 * classic_data_bytes(frame);
  return {.nominal_rate = stuffed + (stuffed - 1) / 4 + classic_tail_bits};
}

FrameBits exact_bits(const CanFrame& frame) noexcept {
  if (frame.fd) return fd_bits(frame, true);
  return {.nominal_rate = exact_classic_bits(frame)};
}

Nanoseconds duration_ns(const FrameBits& bits, const BitRates& rates) noexcept {
  return to_ns(bits.nominal_rate / rates.nominal + bits.data_rate / rates.data);
}

Nanoseconds duration_ns(int nominal_rate_bits, const BitRates& rates) noexcept {
  return duration_ns(FrameBits{.nominal_rate = nominal_rate_bits}, rates);
}

}  // namespace godobject
