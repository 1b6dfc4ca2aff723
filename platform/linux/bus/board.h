// An encoder board on a serial port as a bus of CiA 406 encoders: `board:/dev/ttyACM0`. See
// hal/board/nodes.h.
#pragma once

#include <string>
#include <vector>

#include "hal/board/nodes.h"
#include "platform/linux/bus/bus.h"
#include "platform/linux/serial_port.h"

namespace godobject {

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
