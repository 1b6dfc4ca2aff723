#include "sim/sim_encoder.h"

#include <cmath>

#include "hal/cia406.h"

namespace godobject {

std::uint32_t counts_at(double q, const Calibration& calibration) noexcept {
  constexpr std::uint32_t no_value = 0x8000'0000u;
  if (std::isnan(q)) return no_value;
  constexpr std::int64_t counts_of_32_bits = std::int64_t{1} << 32;
  const std::int64_t modulus = calibration.modulus_counts == 0
                                   ? counts_of_32_bits
                                   : static_cast<std::int64_t>(calibration.modulus_counts);
  const auto from_offset =
      saturate_to<std::int64_t>(calibration.sign * (q - calibration.home) * calibration.counts_per_unit);
  const std::int64_t wrapped = (from_offset % modulus + calibration.offset_counts % modulus) % modulus;
  return static_cast<std::uint32_t>(wrapped < 0 ? wrapped + modulus : wrapped);
}

void SimEncoder::on_sync(Nanoseconds) noexcept {
  send(cia406::make_position(node_id(), counts_at(q_, calibration_)));
}

}  // namespace godobject
