// A cable between two ends in one program: the host's bus at one, the test's device at the other.
#pragma once

#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <string>

#include "platform/linux/bus/bus.h"

namespace godobject::test {

/// Frames are packets of a socket pair, which is recreated each time the host opens its end. The far end
/// belongs to one other thread.
class Cable {
 public:
  ~Cable() {
    for (const int fd : {far_fd_, new_far_fd_.load()})
      if (fd >= 0) ::close(fd);
  }

  /// Opens the host's end; returns -1 while the cable is unplugged.
  int open_host() {
    if (!plugged_) {
      ++refused_opens_;
      return -1;
    }
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends) != 0) return -1;
    const int unclaimed = new_far_fd_.exchange(ends[1]);
    if (unclaimed >= 0) ::close(unclaimed);
    return ends[0];
  }
  int refused_opens() const { return refused_opens_; }

  // Far end.
  int far_fd() {
    const int fd = new_far_fd_.exchange(-1);
    if (fd >= 0) {
      if (far_fd_ >= 0) ::close(far_fd_);
      far_fd_ = fd;
    }
    return far_fd_;
  }
  void unplug() {
    plugged_ = false;
    if (far_fd() >= 0) ::close(far_fd_);
    far_fd_ = -1;
  }
  void plug() { plugged_ = true; }
  bool plugged() const { return plugged_; }

 private:
  std::atomic<bool> plugged_{true};
  std::atomic<int> refused_opens_{0};
  std::atomic<int> new_far_fd_{-1};
  int far_fd_ = -1;
};

/// The host's end.
class CableBus final : public LinuxBus {
 public:
  explicit CableBus(Cable& cable) : cable_(cable) {}
  ~CableBus() override { close(); }

  [[nodiscard]] bool open() noexcept override {
    close();
    fd_ = cable_.open_host();
    state_ = fd_ >= 0 ? BusState::error_active : BusState::closed;
    return fd_ >= 0;
  }
  void close() noexcept override {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
    state_ = BusState::closed;
  }
  [[nodiscard]] SendResult try_send(const CanFrame& frame) noexcept override {
    SendResult result = SendResult::down;
    if (!is_cut_off(state_)) {
      const bool sent = ::send(fd_, &frame, sizeof frame, MSG_NOSIGNAL) == sizeof frame;
      result = sent ? SendResult::queued : errno == EAGAIN ? SendResult::full : SendResult::down;
      if (result == SendResult::down) state_ = BusState::gone;
    }
    ++(result == SendResult::queued ? counters_.sent : counters_.send_refused);
    return result;
  }
  [[nodiscard]] bool try_receive(ReceivedFrame& out) noexcept override {
    if (is_cut_off(state_)) return false;
    const ssize_t size = recv(fd_, &out, sizeof out, 0);
    if (size == 0 || (size < 0 && errno != EAGAIN)) state_ = BusState::gone;
    counters_.received += size == sizeof out ? 1 : 0;
    return size == sizeof out;
  }
  BusState state() const noexcept override { return state_; }
  BusCounters counters() const noexcept override { return counters_; }
  int descriptor() const noexcept override { return fd_; }
  std::string trouble() const override {
    return is_cut_off(state_) ? "the cable is unplugged: plug it in" : "";
  }

 private:
  Cable& cable_;
  int fd_ = -1;
  BusState state_ = BusState::closed;
  BusCounters counters_;
};

}  // namespace godobject::test
