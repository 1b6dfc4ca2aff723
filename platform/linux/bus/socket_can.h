// A CAN interface of Linux (SocketCAN): classic and FD, with the error frames of its driver. Kernel:
// Documentation/networking/can.rst.
#pragma once

#include <linux/can.h>
#include <net/if.h>
#include <sys/socket.h>

#include <string>
#include <vector>

#include "hal/can/error.h"
#include "platform/linux/bus/socket_can_frame.h"
#include "platform/linux/can_link.h"
#include "platform/linux/receive_stamp.h"

namespace godobject {

/// The filters work in the kernel, also on own frames. They must pass the identifiers of own frames, so that
/// BusCounters::sent counts them. An interface that goes down and up again is reused automatically. One that
/// was unplugged needs close() and open(), which looks it up by name.
class SocketCanBus final : public LinuxBus {
 public:
  SocketCanBus(const std::string& interface, const BusSettings& settings);
  ~SocketCanBus() override;
  SocketCanBus(const SocketCanBus&) = delete;
  SocketCanBus& operator=(const SocketCanBus&) = delete;

  /// Returns false if the interface is missing or down, or its bit rates differ from the expected ones.
  [[nodiscard]] bool open() noexcept override;
  /// Counters are kept.
  void close() noexcept override;
  [[nodiscard]] SendResult try_send(const CanFrame& frame) noexcept override;
  /// Returns false also after 64 error frames and own frames in a row; the descriptor stays readable.
  [[nodiscard]] bool try_receive(ReceivedFrame& out) noexcept override;
  BusState state() const noexcept override { return state_; }
  BusCounters counters() const noexcept override { return counters_; }

  int descriptor() const noexcept override { return fd_; }
  std::string trouble() const override;
  std::string name() const override { return interface_; }
  std::string as_written(const CanFrame& frame) const override;
  [[nodiscard]] bool observe(const FrameObserver& observer) noexcept override {
    observer_ = observer;
    return true;
  }

 private:
  struct Message;

  bool check_link() noexcept;
  bool set_options() noexcept;
  bool bind_to_interface() noexcept;
  bool fail(const char* what) noexcept;
  SendResult send_now(const CanFrame& frame) noexcept;
  SendResult refused(int error) noexcept;
  void lose_interface(int error) noexcept;
  bool is_up() const noexcept;
  std::string present_name() const;
  void count_overflow(std::uint32_t dropped_in_all) noexcept;
  bool read_message(Message& message) noexcept;
  bool take(const Message& message, ReceivedFrame& out) noexcept;
  void seen_alive() noexcept;
  std::string why_not_open() const;
  std::string why_state() const;
  BusSettings settings() const noexcept { return {bit_rate_, data_bit_rate_, {}}; }

  std::string interface_;
  unsigned index_ = 0;  // index of the interface that was opened last; renaming does not change it
  double bit_rate_ = 0;
  double data_bit_rate_ = 0;
  std::vector<can_filter> filters_;

  int fd_ = -1;
  bool carries_fd_ = false;
  BusState state_ = BusState::closed;
  BusCounters counters_;
  std::uint64_t queue_full_ = 0;      // try_send calls answered with full
  std::uint32_t dropped_in_all_ = 0;  // frames lost by this socket, as counted by the kernel (SO_RXQ_OVFL)
  ReceiveStamp stamp_;
  FrameObserver observer_;
  // Reason of the last failed open().
  const char* failed_call_ = nullptr;
  int failed_errno_ = 0;
  LinkFit fit_ = LinkFit::fits;
};

}  // namespace godobject
