// A stranger on a simulated bus: it sends the same frames once per period, and answers none.
#pragma once

#include <vector>

#include "hal/rig/params.h"
#include "sim/node/node.h"

namespace godobject {

class SimStranger final : public SimNode {
 public:
  /// Allocates; no other function does. bus: opened by the caller, outlives this. frames: of one period.
  SimStranger(CanBus& bus, std::vector<CanFrame> frames) : bus_(bus), frames_(std::move(frames)) {}

  void set_period(Nanoseconds period_ns) noexcept { period_ns_ = period_ns; }

  void poll(Nanoseconds now) noexcept override;
  Nanoseconds next_timer() const noexcept override { return t_next_ns_; }
  std::uint8_t node_id() const noexcept override { return 0; }
  void power_cycle(Nanoseconds now) noexcept override { t_next_ns_ = now; }
  void trip(std::uint16_t) noexcept override {}
  void set_clock_error(double, Nanoseconds) noexcept override {}

 private:
  CanBus& bus_;
  std::vector<CanFrame> frames_;
  Nanoseconds period_ns_ = 10'000'000;
  Nanoseconds t_next_ns_ = 0;
};

/// Returns the frames of another host: on a CANopen bus SYNC and a heartbeat, on any other a command to each
/// drive.
std::vector<CanFrame> frames_of_second_host(const RigParams& rig, std::size_t bus);

/// Frame that belongs to no node and wins against SYNC: no protocol of a rig has its identifier.
inline constexpr CanFrame flooding_frame{.id = 0x07Fu << 18,
                                         .extended = true,
                                         .size = 8,
                                         .data = {0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55}};

}  // namespace godobject
