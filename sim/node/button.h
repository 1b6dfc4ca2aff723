// Simulated digital input node (CiA 401): the device's buttons.
#pragma once

#include "hal/canopen/cia401.h"
#include "sim/node/canopen/node.h"

namespace godobject {

/// Sends TPDO1 {6000h:01} when an input changes, when the node becomes operational, and by its event timer,
/// which compensates for a lost message.
class SimButtonNode final : public SimCanopenNode {
 public:
  static constexpr std::uint16_t event_ms = 50;

  SimButtonNode(CanBus& bus, std::uint8_t node_id, Nanoseconds heartbeat_period_ns);

  /// Sets the states of the eight inputs.
  void set_inputs(std::uint8_t inputs) noexcept { inputs_ = inputs; }

 private:
  void sample() noexcept override { shown_->value = inputs_; }
  void on_nmt_state(Nanoseconds now) noexcept override;
  void on_tick(Nanoseconds now) noexcept override;

  Object* shown_ = nullptr;  // 6000h:01
  std::uint8_t inputs_ = 0;
  std::uint8_t sent_ = 0;
};

/// 1018h of simulated button nodes. CiA has not assigned this vendor id.
inline constexpr lss::Identity sim_button_identity{
    .vendor = 0x0000'0DEB, .product = 0x401, .revision = 0x0001'0000, .serial = 1};

}  // namespace godobject
