// Simulated CiA 406 absolute encoder.
#pragma once

#include "hal/rig/params.h"
#include "sim/node/canopen/node.h"

namespace godobject {

/// Counts sent by a sensor without a value.
inline constexpr std::uint32_t no_value_counts = 0x8000'0000u;

/// Returns the counts at joint coordinate q (rad or m), the inverse of Calibration: rounded, wrapped at the
/// modulus (2^32 if the calibration has none). Returns no_value_counts for NaN.
std::uint32_t counts_at(double q, const Calibration& calibration) noexcept;

/// Samples its position at SYNC and sends it as TPDO1. With factory settings TPDO1 waits for an event timer
/// of 0, and TPDO2 answers SYNC, as for Lika, BEI and SICK. The preset 6003h sets the present position; the
/// resulting offset 6509h is kept.
class SimEncoder final : public SimCanopenNode {
 public:
  /// calibration: that of the encoder in the scene; determines 6001h, 6002h, 6501h, 6502h.
  SimEncoder(CanBus& bus, std::uint8_t node_id, const Calibration& calibration,
             Nanoseconds heartbeat_period_ns, SimDefaults defaults = SimDefaults::rig);

  /// Sets the true joint coordinate (rad or m) and its rate, from the plant.
  void set_position(double q, double q_dot = 0) noexcept {
    q_ = q;
    q_dot_ = q_dot;
  }

 private:
  void sample() noexcept override;
  void on_object_written(canopen::ObjectAddress address, std::int64_t value) noexcept override;
  std::int64_t range_counts() const noexcept;

  Calibration calibration_;
  double q_ = 0;
  double q_dot_ = 0;
  Object* position_ = nullptr;  // 6004h
  Object* speed_ = nullptr;     // 6030h:01
  Object* offset_ = nullptr;    // 6509h, counts
};

/// 1018h of simulated encoders. CiA has not assigned this vendor id.
inline constexpr lss::Identity sim_encoder_identity{
    .vendor = 0x0000'0DEB, .product = 0x406, .revision = 0x0001'0000, .serial = 1};

}  // namespace godobject
