#include "sim/node/encoder.h"

#include <algorithm>
#include <cmath>

namespace godobject {

using canopen::ObjectType;

std::uint32_t counts_at(double q, const Calibration& calibration) noexcept {
  if (std::isnan(q)) return no_value_counts;
  constexpr std::int64_t counts_of_32_bits = std::int64_t{1} << 32;
  const std::int64_t modulus = calibration.modulus_counts == 0
                                   ? counts_of_32_bits
                                   : static_cast<std::int64_t>(calibration.modulus_counts);
  const auto from_offset =
      saturate_to<std::int64_t>(calibration.sign * (q - calibration.home) * calibration.counts_per_unit);
  const std::int64_t wrapped = (from_offset % modulus + calibration.offset_counts % modulus) % modulus;
  return static_cast<std::uint32_t>(wrapped < 0 ? wrapped + modulus : wrapped);
}

SimEncoder::SimEncoder(CanBus& bus, std::uint8_t node_id, const Calibration& calibration,
                       Nanoseconds heartbeat_period_ns, SimDefaults defaults)
    : SimCanopenNode(bus, node_id, defaults == SimDefaults::rig ? heartbeat_period_ns : 0),
      calibration_(calibration) {
  constexpr std::uint32_t device_type_406_multi_turn = 0x0002'0196;
  constexpr auto ro = ObjectAccess::read_only;
  const bool ours = defaults == SimDefaults::rig;
  identify(device_type_406_multi_turn, "simulated CiA 406 encoder", sim_encoder_identity);

  ObjectDictionary& o = objects();
  const std::int64_t range = std::min<std::int64_t>(range_counts(), 0xFFFF'FFFF);
  position_ = &o.add_mappable({0x6004, 0}, ObjectType::u32, ro);
  speed_ = &o.add_mappable({0x6030, 1}, ObjectType::i16, ro);
  o.add({0x6000, 0}, ObjectType::u16, ObjectAccess::read_write);
  o.add({0x6001, 0}, ObjectType::u32, ObjectAccess::read_write, range);
  o.add({0x6002, 0}, ObjectType::u32, ObjectAccess::read_write, range);
  o.add({0x6003, 0}, ObjectType::u32, ObjectAccess::read_write).high = range - 1;
  o.add({0x6500, 0}, ObjectType::u16, ro);         // operating status
  o.add({0x6501, 0}, ObjectType::u32, ro, range);  // counts of a turn
  o.add({0x6502, 0}, ObjectType::u16, ro, 1);      // turns
  o.add({0x6503, 0}, ObjectType::u16, ro);         // alarms, supported alarms, warnings, supported warnings
  o.add({0x6504, 0}, ObjectType::u16, ro, 1);
  o.add({0x6505, 0}, ObjectType::u16, ro);
  o.add({0x6506, 0}, ObjectType::u16, ro);
  o.add({0x6507, 0}, ObjectType::u32, ro, 0x0003'0002);  // versions of profile and software
  o.add({0x6508, 0}, ObjectType::u32, ro);               // operating time, 0.1 h
  offset_ = &o.add({0x6509, 0}, ObjectType::i32, ro);
  add_pdo({.number = 1, .transmission = ours ? std::uint8_t{1} : event_driven, .map = {{0x6004, 0}}});
  add_pdo({.number = 2, .on = !ours, .transmission = 1, .map = {{0x6004, 0}}});
}

std::int64_t SimEncoder::range_counts() const noexcept {
  constexpr std::int64_t of_32_bits = std::int64_t{1} << 32;
  return calibration_.modulus_counts == 0 ? of_32_bits
                                          : static_cast<std::int64_t>(calibration_.modulus_counts);
}

void SimEncoder::sample() noexcept {
  const std::int64_t counts = counts_at(q_, calibration_) + offset_->value;
  if (std::isnan(q_)) position_->value = no_value_counts;
  else position_->value = (counts % range_counts() + range_counts()) % range_counts();
  speed_->value = saturate_to<std::int16_t>(calibration_.sign * q_dot_ * calibration_.counts_per_unit);
}

void SimEncoder::on_object_written(canopen::ObjectAddress address, std::int64_t value) noexcept {
  constexpr canopen::ObjectAddress preset{0x6003, 0};
  if (address != preset) return;
  offset_->value = value - counts_at(q_, calibration_);
  offset_->power_up = offset_->value;
}

}  // namespace godobject
