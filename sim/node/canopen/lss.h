// LSS slave of a simulated node (CiA 305): node-ID and bit rate set over the bus.
#pragma once

#include "hal/canopen/lss.h"

namespace godobject {

class SimLss {
 public:
  explicit SimLss(std::uint8_t node_id) noexcept : pending_{.node_id = node_id}, stored_(pending_) {}

  /// Returns the answer to a master's message, if any.
  std::optional<lss::Message> answer(const lss::Message& request, const lss::Identity& own) noexcept;

  /// Returns the node-ID in effect after the next communication reset.
  std::uint8_t node_id() const noexcept { return pending_.node_id; }
  /// Returns the index in the table of CiA 305, in effect after activation. The simulated wire keeps its
  /// rate.
  std::uint8_t bit_timing() const noexcept { return active_bit_timing_; }
  /// Restores the stored settings.
  void power_cycle() noexcept;

 private:
  struct Settings {
    std::uint8_t node_id = 1;
    std::uint8_t bit_timing = 0;  // 1 Mbit/s
  };

  bool selects(const lss::Message& request, const lss::Identity& own) noexcept;

  lss::Mode mode_ = lss::Mode::waiting;
  Settings pending_, stored_;
  std::uint8_t active_bit_timing_ = 0;
  std::size_t matched_ = 0;  // number of matched identity numbers, in order
};

}  // namespace godobject
