// A second host on a simulated bus: it sends the frames of a rig's host, independent of the rig's own host.
#pragma once

#include <vector>

#include "hal/rig/params.h"
#include "sim/node/node.h"

namespace godobject {

/// On a CANopen bus it sends SYNC and a heartbeat once per period, on any other a command to each drive.
class SimSecondHost final : public SimNode {
 public:
  /// Allocates; no other function does. bus: opened by the caller, outlives this.
  SimSecondHost(CanBus& bus, const RigParams& rig, std::size_t index_of_bus);

  void set_period(Nanoseconds period_ns) noexcept { period_ns_ = period_ns; }

  void poll(Nanoseconds now) noexcept override;
  Nanoseconds next_timer() const noexcept override { return t_next_ns_; }
  std::uint8_t node_id() const noexcept override { return 0; }
  void power_cycle(Nanoseconds now) noexcept override { t_next_ns_ = now; }
  void trip(std::uint16_t) noexcept override {}
  void set_clock_error(double, Nanoseconds) noexcept override {}

 private:
  CanBus& bus_;
  std::vector<CanFrame> frames_;  // frames per period
  Nanoseconds period_ns_ = 10'000'000;
  Nanoseconds t_next_ns_ = 0;
};

}  // namespace godobject
