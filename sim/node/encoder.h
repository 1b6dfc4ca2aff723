// A simulated CiA 406 absolute encoder.
#pragma once

#include "hal/rig/params.h"
#include "sim/node/canopen/node.h"

namespace godobject {

/// What a sensor sends that has no value to send.
inline constexpr std::uint32_t no_value_counts = 0x8000'0000u;

/// The count a sensor shows at joint coordinate q (rad or m): the nearest one, wrapped at the modulus
/// (2^32 when the calibration has none). The inverse of Calibration. For NaN: no_value_counts.
std::uint32_t counts_at(double q, const Calibration& calibration) noexcept;

/// Samples its position when a SYNC arrives and sends it as TPDO1. Out of the factory TPDO1 waits for an event
/// timer that is 0, and TPDO2 answers the SYNC, as those of Lika, BEI and SICK do. The preset 6003h is the
/// position from then on; the offset 6509h that it makes is kept.
class SimEncoder final : public SimCanopenNode {
 public:
  /// calibration: what the scene says of the encoder; 6001h, 6002h, 6501h, 6502h follow from it.
  SimEncoder(CanBus& bus, std::uint8_t node_id, const Calibration& calibration,
             Nanoseconds heartbeat_period_ns, SimDefaults defaults = SimDefaults::rig);

  /// True joint coordinate (rad or m) and its rate, from the plant.
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

/// What simulated encoders say of themselves in 1018h. The vendor is none that CiA has given away.
inline constexpr lss::Identity sim_encoder_identity{
    .vendor = 0x0000'0DEB, .product = 0x406, .revision = 0x0001'0000, .serial = 1};

}  // namespace godobject
