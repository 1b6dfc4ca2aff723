// CAN over SLCAN on UART 0 of QEMU's mps2-an500 (CMSDK APB UART), which has no CAN controller. Bytes arrive by
// interrupt; lines and frames are those of hal/can/slcan.h. Allocates nothing, waits for a bounded time.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "board.h"
#include "hal/can/slcan.h"

namespace board {

struct Uart {
  volatile std::uint32_t data, state, control, interrupt, divider;

  static constexpr std::uint32_t transmit_full = 1, receive_full = 2;               // state
  static constexpr std::uint32_t transmit = 1, receive = 2, receive_interrupt = 8;  // control
  static constexpr std::uint32_t received = 2;  // interrupt; written: cleared
};
inline Uart& uart0() { return *reinterpret_cast<Uart*>(0x40004000); }
inline constexpr std::uint32_t uart0_receive_line = 0;  // of the interrupt controller
inline void enable_interrupt(std::uint32_t line) {
  *reinterpret_cast<volatile std::uint32_t*>(0xe000e100) = 1u << line;
}

/// Bytes from the interrupt to the loop. A byte that does not fit is dropped and counted.
class ReceivedBytes {
 public:
  void put(std::uint8_t byte) {
    const std::uint32_t in = in_.load(std::memory_order_relaxed);
    if (in - out_.load(std::memory_order_acquire) == bytes_.size()) {
      num_dropped_.store(num_dropped() + 1, std::memory_order_relaxed);
      return;
    }
    bytes_[in % bytes_.size()] = byte;
    in_.store(in + 1, std::memory_order_release);
  }
  bool take(std::uint8_t& byte) {
    const std::uint32_t out = out_.load(std::memory_order_relaxed);
    if (out == in_.load(std::memory_order_acquire)) return false;
    byte = bytes_[out % bytes_.size()];
    out_.store(out + 1, std::memory_order_release);
    return true;
  }
  std::uint32_t num_dropped() const { return num_dropped_.load(std::memory_order_relaxed); }

 private:
  std::array<std::uint8_t, 512> bytes_{};
  std::atomic<std::uint32_t> in_ = 0, out_ = 0, num_dropped_ = 0;  // bytes so far
};
inline ReceivedBytes received;

/// Takes the bytes that have arrived: the work of the interrupt.
inline void receive_bytes() {
  uart0().interrupt = Uart::received;
  while ((uart0().state & Uart::receive_full) != 0) received.put(static_cast<std::uint8_t>(uart0().data));
}

/// Host side of an SLCAN adapter at the other end of UART 0.
class UartBus {
 public:
  /// Opens the channel at 1 Mbit/s. Replies are not awaited: a channel that is shut sends no frames.
  void open() {
    uart0().divider = 25;  // 1 Mbaud from 25 MHz
    uart0().control = Uart::transmit | Uart::receive | Uart::receive_interrupt;
    enable_interrupt(uart0_receive_line);
    for (const std::string_view command :
         {std::string_view("\r"), godobject::slcan::close_command, godobject::slcan::bit_rate_command(1e6),
          godobject::slcan::open_command})
      write(command);
  }
  /// Returns false if the line was not accepted within some milliseconds.
  bool try_send(const godobject::CanFrame& frame) {
    std::array<char, godobject::slcan::max_line> line;
    const std::size_t size = godobject::slcan::format_frame(frame, line);
    return size > 0 && (!is_cut_ || write("\r")) && write({line.data(), size});
  }
  /// Returns true with the next frame among the bytes that have arrived.
  bool try_receive(godobject::CanFrame& frame) {
    for (std::uint8_t byte = 0; received.take(byte);) {
      godobject::slcan::Reply reply;
      if (!reader_.put(byte) || parse_reply(reader_.line(), reply) != godobject::ParseResult::ok) continue;
      if (reply.kind != godobject::slcan::ReplyKind::frame) continue;
      frame = reply.frame;
      return true;
    }
    return false;
  }

 private:
  bool write(std::string_view text) {
    constexpr int patience = 200'000;  // readings of the state
    int left = patience;
    is_cut_ = true;
    for (const char c : text) {
      while ((uart0().state & Uart::transmit_full) != 0)
        if (--left == 0) return false;
      uart0().data = static_cast<std::uint8_t>(c);
    }
    is_cut_ = false;
    return true;
  }

  godobject::slcan::LineReader reader_;
  bool is_cut_ = false;  // true if a line was sent in part
};

}  // namespace board
