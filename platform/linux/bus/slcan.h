// Buses on serial ports. CAN buses of SLCAN lines are in user space, without a kernel driver. SlcanBus is
// behind an adapter; PtyBus simulates such an adapter on a pseudo-terminal. hal/can/slcan.h lists the
// limits of the protocol; docs/buses.md their consequences for a rig. BoardBus is an encoder board.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/board/nodes.h"
#include "hal/can/slcan.h"
#include "platform/linux/bus/bus.h"
#include "platform/linux/serial_port.h"
#include "platform/rt/signals.h"

namespace godobject {

/// A serial port with SLCAN lines, shared by both ends of the protocol. Neither put() nor next() waits or
/// allocates.
class SlcanLine {
 public:
  SerialPort& port() noexcept { return port_; }
  const SerialPort& port() const noexcept { return port_; }

  /// Queues `text` and writes as much as the port accepts. Returns false and queues nothing if there is no
  /// space for all of it.
  [[nodiscard]] bool put(std::string_view text) noexcept;
  /// Writes queued lines, as many as the port accepts, one write per line. Some adapters read one command of
  /// a USB packet and drop the others.
  void flush() noexcept;
  /// Returns the line of a frame; empty if the protocol cannot carry it.
  static std::string text_of(const CanFrame& frame);
  /// Returns the rest of the line that the last write cut off.
  const LineRest& rest() const noexcept { return rest_; }
  /// Returns the next complete line, valid until the next call. False if there is none yet, or if the limit
  /// on reads per call is reached.
  [[nodiscard]] bool next(std::string_view& line) noexcept;
  /// Time of reading the last line's final bytes: CLOCK_MONOTONIC.
  Nanoseconds read_at() const noexcept { return read_at_; }
  /// Discards queued output.
  void discard_output() noexcept { out_size_ = 0; }
  /// Discards received bytes: the next byte begins a line.
  void discard_input() noexcept;
  /// Discards queued output and received bytes.
  void clear() noexcept;

  /// Counts and beginnings of lines that were dropped.
  const slcan::LineReader& reader() const noexcept { return reader_; }

 private:
  SerialPort port_{};
  slcan::LineReader reader_{};
  std::array<std::uint8_t, 64 * slcan::max_line> out_{};  // some milliseconds of a busy bus
  std::size_t out_size_ = 0;
  LineRest rest_{};
  std::array<std::uint8_t, 512> in_{};
  std::size_t in_begin_ = 0, in_end_ = 0;
  Nanoseconds read_at_ = 0;
};

/// A CAN bus behind an SLCAN adapter on a serial port.
/// Counters: `sent` counts frames that the adapter acknowledged; 0 with an adapter that acknowledges none.
/// send_dropped: frames that it refused after they had been queued here. error_frames: garbled lines, and bus
/// errors in the adapter's flags.
class SlcanBus final : public LinuxBus {
 public:
  /// where: path of a serial port, optionally a comma and its baud rate, 115200 by default. USB adapters of
  /// the class CDC-ACM have no baud rate.
  SlcanBus(const std::string& where, const BusSettings& settings);
  ~SlcanBus() override { close(); }

  /// The only call that waits: for the adapter's answers, each at most answer_timeout.
  bool open() noexcept override;
  void close() noexcept override;
  SendResult try_send(const CanFrame& frame) noexcept override;
  bool try_receive(ReceivedFrame& out) noexcept override;
  BusState state() const noexcept override;
  BusCounters counters() const noexcept override;

  int descriptor() const noexcept override { return line_.port().descriptor(); }
  std::string trouble() const override;
  std::string name() const override { return path_; }
  std::string as_written(const CanFrame& frame) const override;
  std::string slowness() const override { return line_.port().slowness(); }
  const LineRest* line_rest() const noexcept override { return &line_.rest(); }
  const SerialPort& port() const noexcept { return line_.port(); }

  static constexpr Nanoseconds answer_timeout = 500'000'000;
  static constexpr Nanoseconds flags_period = 100'000'000;  // between two requests for the adapter's flags

 private:
  bool fail(std::string why);
  void wait_for_quiet();
  enum class Answer : std::uint8_t { none, ok, refused, flags };
  Answer ask(std::string_view command, Nanoseconds patience);
  Nanoseconds patience() const noexcept;
  std::string ask_version(const std::string& wanted);
  bool answers_version();
  bool command(std::string_view command, const std::string& what);
  bool handle(std::string_view line, ReceivedFrame& out) noexcept;
  void handle_flags(std::uint8_t flags) noexcept;
  void acknowledge(bool taken) noexcept;
  std::uint64_t num_garbled() const noexcept;

  std::string path_;
  std::uint32_t baud_ = 0;  // 0: the given text is not a number
  double bit_rate_, data_bit_rate_;
  std::vector<CanFilter> filters_;
  SlcanLine line_{};
  BusState state_ = BusState::closed;
  BusCounters counters_{};
  std::uint64_t num_unanswered_ = 0;   // frames sent and neither accepted nor refused yet
  std::uint64_t num_garbled_ = 0;      // lines that are not of the protocol
  std::uint64_t earlier_garbled_ = 0;  // garbled lines before the port was opened again
  std::uint64_t dropped_at_open_ = 0;  // lines of the reader that were dropped while the adapter was being
                                       // opened
  std::uint64_t num_fd_ = 0;           // CAN FD frames
  std::string version_{};              // answer to V of an adapter that acknowledges no commands; else empty
  bool has_flags_ = false;             // true if the adapter answers F (request of flags)
  bool reports_state_ = false;         // true for the dialect of Linux's driver, which reports more than F
  Nanoseconds flags_due_ = 0;
  std::string why_{};
};

/// A CAN bus on a pseudo-terminal: simulates an SLCAN adapter for the program that opens name().
/// Such programs are SlcanBus, python-can's slcan interface and slcand of can-utils.
/// Is `down` until the other end opens its channel (O or L), and after it closes it (C). try_receive answers
/// commands. `sent` counts frames written to the terminal. Refuses time stamps, bit timing registers and
/// acceptance filters (Z, s, M, m), as an adapter may.
class PtyBus final : public LinuxBus {
 public:
  explicit PtyBus(const BusSettings& settings);
  ~PtyBus() override { close(); }

  /// Makes a pseudo-terminal, a new one each time.
  bool open() noexcept override;
  void close() noexcept override;
  SendResult try_send(const CanFrame& frame) noexcept override;
  bool try_receive(ReceivedFrame& out) noexcept override;
  BusState state() const noexcept override;
  BusCounters counters() const noexcept override { return counters_; }

  int descriptor() const noexcept override { return line_.port().descriptor(); }
  std::string trouble() const override;
  /// Path of the terminal for the other end; empty while closed.
  std::string name() const override;
  std::string as_written(const CanFrame& frame) const override;
  std::string slowness() const override { return line_.port().slowness(); }

 private:
  enum class Channel : std::uint8_t { closed, open, listening };

  bool handle(std::string_view line, ReceivedFrame& out) noexcept;
  bool receive(const CanFrame& frame, ReceivedFrame& out) noexcept;
  void answer(std::string_view text) noexcept;
  void open_channel(Channel channel) noexcept;
  void close_channel() noexcept;

  double bit_rate_;
  std::vector<CanFilter> filters_;
  SlcanLine line_{};
  int slave_fd_ = -1;  // kept open, because reading the master without an open slave is an error
  Channel channel_ = Channel::closed;
  double requested_bit_rate_ = 0;  // bit rate set by the other end; 0: not set
  BusCounters counters_{};
  std::string why_{};
};

// ---- encoder boards: `board:/dev/ttyACM0`, see hal/board/nodes.h ---------------------------------------

/// An encoder board on a serial port as a bus of CiA 406 encoders.
/// Counters: error_frames are broken frames of the board (CRC, cut off), receive_overflow those missing in
/// its sequence.
class BoardBus final : public LinuxBus {
 public:
  static constexpr std::uint32_t default_baud = 921'600;

  /// where: path of a serial port, optionally a comma and its baud rate, 921600 by default.
  BoardBus(const std::string& where, const BusSettings& settings);
  ~BoardBus() override { close(); }

  bool open() noexcept override;
  void close() noexcept override;
  SendResult try_send(const CanFrame& frame) noexcept override;
  bool try_receive(ReceivedFrame& out) noexcept override;
  BusState state() const noexcept override;
  BusCounters counters() const noexcept override;

  /// Readable when the board has sent bytes, and when the nodes have sent frames.
  int descriptor() const noexcept override { return waiting_fd_; }
  std::string trouble() const override;
  std::string slowness() const override { return port_.slowness(); }
  std::string name() const override { return address_.path; }

 private:
  bool fail(const char* what);
  void read_port() noexcept;
  void arm_timer() noexcept;

  SerialAddress address_;
  double bit_rate_;
  std::vector<CanFilter> filters_;
  SerialPort port_;
  BoardNodes nodes_;
  int timer_fd_ = -1;    // timer for pending frames of the nodes
  int waiting_fd_ = -1;  // epoll on the port and the timer
  BusCounters counters_{};
  BoardCounters earlier_{};  // counters of earlier openings
  std::string why_{};
};

}  // namespace godobject
