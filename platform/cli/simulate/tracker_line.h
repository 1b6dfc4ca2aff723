// A simulated tracker on a pseudo-terminal, for a host that knows nothing of it.
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

  /// Empty, or why there is no pseudo-terminal.
  std::string open();
  /// Bytes of the host in, what the tracker has to say out. What nobody reads waits, and is lost once its queue is full.
  void step(Nanoseconds now) noexcept;

  const std::string& name() const noexcept { return name_; }
  const std::string& path() const noexcept { return port_.path(); }
  int descriptor() const noexcept { return port_.descriptor(); }
  SimTracker& far() noexcept { return *far_; }
  const SimTracker& far() const noexcept { return *far_; }
  /// Bytes that have come from a host.
  std::uint64_t num_received() const noexcept { return num_received_; }

 private:
  std::string name_;
  std::unique_ptr<SimTracker> far_;
  SerialPort port_;
  int slave_fd_ = -1;
  std::array<std::uint8_t, 512> out_{};
  std::span<const std::uint8_t> unsent_{};  // of out_
  std::uint64_t num_received_ = 0;
};

}  // namespace godobject
