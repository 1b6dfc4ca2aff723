// A simulated CiA 406 absolute encoder.
#pragma once

#include "hal/rig_params.h"
#include "sim/sim_canopen_node.h"

namespace godobject {

/// The count a sensor shows at joint coordinate q (rad or m): the nearest one, wrapped at the modulus
/// (2^32 when the calibration has none). The inverse of Calibration. For NaN, 80000000h: no value.
std::uint32_t counts_at(double q, const Calibration& calibration) noexcept;

/// Samples its position when a SYNC arrives and sends it as TPDO1.
class SimEncoder final : public SimCanopenNode {
 public:
  SimEncoder(CanBus& bus, std::uint8_t node_id, const Calibration& calibration,
             Nanoseconds heartbeat_period_ns) noexcept
      : SimCanopenNode(bus, node_id, heartbeat_period_ns), calibration_(calibration) {}

  /// True joint coordinate (rad or m), from the plant.
  void set_position(double q) noexcept { q_ = q; }

 private:
  void on_sync(Nanoseconds now) noexcept override;

  Calibration calibration_;
  double q_ = 0;
};

}  // namespace godobject
