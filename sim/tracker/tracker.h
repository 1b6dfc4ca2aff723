// Simulated tracker: the far end of its serial line. Bytes in, bytes out; it measures the given poses at its
// own rate. Nothing allocates after construction.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "hal/base/fixed_queue.h"
#include "hal/tracker/ndi.h"
#include "hal/tracker/tracker.h"
#include "sim/bus/random.h"

namespace godobject {

/// Active faults, until reset.
struct SimTrackerFaults {
  std::array<bool, max_tracked_tools> missing{};        // hidden
  std::array<bool, max_tracked_tools> disabled{};       // unplugged
  std::array<bool, max_tracked_tools> out_of_volume{};  // NDI only
  bool silent = false;                                  // nothing is sent
  double drop_probability = 0;                          // per message
  double corrupt_probability = 0;                       // per message: one bit is flipped
  Nanoseconds delay = 0;                                // added to every message
};

class SimTracker {
 public:
  static constexpr std::size_t max_message = ndi::ReplyReceiver::capacity;

  /// rate_hz: measurements per second, > 0.
  SimTracker(double rate_hz, std::uint64_t seed) noexcept;
  virtual ~SimTracker() = default;

  /// Receives bytes from the host.
  virtual void receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept = 0;
  /// Called when the host holds the line at 0.
  virtual void serial_break(Nanoseconds) noexcept {}

  /// Sets the tool's pose in the tracker's frame from now on.
  void set_pose(std::size_t tool, const Pose& X_TH) noexcept { poses_[tool] = X_TH; }
  /// Measures when due. Call it at least once per measurement.
  void advance(Nanoseconds now) noexcept;
  /// Writes the bytes sent by now, as many as fit; returns their number.
  std::size_t transmit(std::span<std::uint8_t> out, Nanoseconds now) noexcept;

  SimTrackerFaults faults{};
  /// Returns the number of messages lost because the queue was full.
  std::uint64_t lost_messages() const noexcept { return lost_messages_; }

 protected:
  /// The last measurement.
  struct Measurement {
    std::array<Pose, max_tracked_tools> poses{};
    std::uint32_t frame = 0;
    Nanoseconds t = 0;
  };
  const Measurement& measurement() const noexcept { return measurement_; }
  void restart_frames() noexcept { measurement_.frame = 0; }
  /// Called after every measurement.
  virtual void measured(Nanoseconds) noexcept {}
  void send(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept;

 private:
  struct Message {
    std::array<std::uint8_t, max_message> data{};
    std::size_t size = 0;
    Nanoseconds due = 0;
  };

  std::array<Pose, max_tracked_tools> poses_{};
  Measurement measurement_;
  Nanoseconds period_ = 0;
  Nanoseconds next_measurement_ = 0;
  bool started_ = false;
  FixedQueue<Message, 32> queue_;
  std::size_t sent_ = 0;  // sent bytes of the first message
  std::uint64_t lost_messages_ = 0;
  SplitMix64 random_;
};

/// Makes the far end of the tracker with these parameters.
std::unique_ptr<SimTracker> make_sim_tracker(const TrackerParams& params, double rate_hz, std::uint64_t seed);

}  // namespace godobject
