// Another host on a simulated bus: it sends what a rig's host sends, whatever the rig's own one does.
#pragma once

#include <vector>

#include "hal/rig/params.h"
#include "sim/node/node.h"

namespace godobject {

/// On a CANopen bus SYNC and a heartbeat once a period, on any other a command to each drive.
class SimSecondHost final : public SimNode {
 public:
  /// Allocates; nothing later does. bus: must outlive it and be opened by the caller.
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
  std::vector<CanFrame> frames_;  // of a period
  Nanoseconds period_ns_ = 10'000'000;
  Nanoseconds t_next_ns_ = 0;
};

}  // namespace godobject
