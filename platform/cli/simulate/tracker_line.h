// A simulated tracker on a pseudo-terminal, equal to a real one for a host.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>

#include "platform/linux/serial_port.h"
#include "sim/tracker/tracker.h"

namespace godobject {

class TrackerLine {
 public:
  explicit TrackerLine(std::string name, std::unique_ptr<SimTracker> far)
      : name_(std::move(name)), far_(std::move(far)) {}
  ~TrackerLine();
  TrackerLine(const TrackerLine&) = delete;
  TrackerLine& operator=(const TrackerLine&) = delete;

  /// Returns why there is no pseudo-terminal; empty on success.
  std::string open();
  /// Passes the host's bytes to the tracker, and its bytes to the host. Bytes that are not read wait, and are
  /// lost once the queue is full.
  void step(Nanoseconds now) noexcept;

  const std::string& name() const noexcept { return name_; }
  const std::string& path() const noexcept { return port_.path(); }
  int descriptor() const noexcept { return port_.descriptor(); }
  SimTracker& far() noexcept { return *far_; }
  const SimTracker& far() const noexcept { return *far_; }
  /// Returns the number of bytes received from the host.
  std::uint64_t num_received() const noexcept { return num_received_; }

 private:
  std::string name_;
  std::unique_ptr<SimTracker> far_;
  SerialPort port_;
  int slave_fd_ = -1;
  std::array<std::uint8_t, 512> out_{};
  std::span<const std::uint8_t> unsent_{};  // part of out_
  std::uint64_t num_received_ = 0;
};

}  // namespace godobject
