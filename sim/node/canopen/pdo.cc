#include "sim/node/canopen/pdo.h"

namespace godobject {

using canopen::ObjectAddress;
using canopen::ObjectType;
using sdo::AbortCode;

namespace {

ObjectAddress entry_address(std::int64_t entry) noexcept {
  return {static_cast<std::uint16_t>(entry >> 16 & 0xFFFF), static_cast<std::uint8_t>(entry >> 8 & 0xFF)};
}
unsigned entry_bits(std::int64_t entry) noexcept { return static_cast<unsigned>(entry & 0xFF); }

}  // namespace

SimPdo::SimPdo(ObjectDictionary& objects, SimPdoDefault power_up)
    : objects_(objects), power_up_(std::move(power_up)) {
  const std::uint16_t communication = communication_index(power_up_.direction, power_up_.number);
  const std::uint16_t mapping = mapping_index(power_up_.direction, power_up_.number);
  objects_.add({communication, 0}, ObjectType::u8, ObjectAccess::read_only, 5);
  cob_id_ = &objects_.add({communication, 1}, ObjectType::u32, ObjectAccess::read_write);
  transmission_ = &objects_.add({communication, 2}, ObjectType::u8, ObjectAccess::read_write);
  inhibit_ = &objects_.add({communication, 3}, ObjectType::u16, ObjectAccess::read_write);
  timer_ms_ = &objects_.add({communication, 5}, ObjectType::u16, ObjectAccess::read_write);
  count_ = &objects_.add({mapping, 0}, ObjectType::u8, ObjectAccess::read_write);
  for (std::uint8_t i = 0; i < max_mapped_objects; ++i)
    entries_[i] =
        &objects_.add({mapping, static_cast<std::uint8_t>(i + 1)}, ObjectType::u32, ObjectAccess::read_write);
}

void SimPdo::reset(std::uint8_t node_id) noexcept {
  const std::uint32_t cob_id = default_cob_id(power_up_.direction, power_up_.number, node_id);
  cob_id_->value = power_up_.on ? cob_id : cob_id | SdoSequence::pdo_invalid;
  transmission_->value = power_up_.transmission;
  inhibit_->value = 0;
  timer_ms_->value = power_up_.timer_ms;
  count_->value = 0;
  for (Object* entry : entries_) entry->value = 0;
  for (const ObjectAddress address : power_up_.map) {
    const Object* object = objects_.find(address);
    const auto bits = static_cast<std::uint8_t>(8 * canopen::size_of(object->type));
    entries_[static_cast<std::size_t>(count_->value++)]->value =
        mapping_entry({.address = address, .bits = bits});
  }
  resolve();
  syncs_since_sent = 0;
  has_pending = false;
}

CanFrame SimPdo::pack() const noexcept {
  CanFrame frame{.id = cob_id(), .size = size_};
  std::span<std::uint8_t> rest(frame.data);
  for (std::size_t i = 0; i < static_cast<std::size_t>(count_->value); ++i) {
    const std::size_t size = canopen::size_of(mapped_[i]->type);
    canopen::encode_number(mapped_[i]->value, rest.first(size));
    rest = rest.subspan(size);
  }
  return frame;
}

void SimPdo::unpack(const CanFrame& frame) noexcept {
  std::span<const std::uint8_t> rest(frame.data);
  for (std::size_t i = 0; i < static_cast<std::size_t>(count_->value); ++i) {
    const std::size_t size = canopen::size_of(mapped_[i]->type);
    mapped_[i]->value = canopen::decode_number(rest.first(size), canopen::is_signed(mapped_[i]->type));
    rest = rest.subspan(size);
  }
}

AbortCode SimPdo::may_write(ObjectAddress address, std::int64_t value) const noexcept {
  if (address.index == communication_index(direction(), number()))
    return may_write_communication(address.sub, value);
  if (address.index == mapping_index(direction(), number())) return may_write_mapping(address.sub, value);
  return AbortCode::none;
}

AbortCode SimPdo::may_write_communication(std::uint8_t sub, std::int64_t value) const noexcept {
  constexpr std::int64_t extended_frame = 1 << 29;
  switch (sub) {
    case 1: {
      const bool stays_on = on() && (value & SdoSequence::pdo_invalid) == 0;
      const bool other_identifier = ((value ^ cob_id_->value) & 0x3FFF'FFFF) != 0;
      if (stays_on && other_identifier) return AbortCode::invalid_value;
      const bool goes_on = !on() && (value & SdoSequence::pdo_invalid) == 0;
      if (goes_on && count_->value == 0) return AbortCode::invalid_value;
      return (value & extended_frame) != 0 ? AbortCode::invalid_value : AbortCode::none;
    }
    case 2: {
      constexpr std::int64_t first_event_driven = 254;
      const bool known = value <= max_synchronous || value >= first_event_driven;
      return known ? AbortCode::none : AbortCode::invalid_value;
    }
    case 3: return on() ? AbortCode::device_state : AbortCode::none;
    default: return AbortCode::none;
  }
}

AbortCode SimPdo::may_write_mapping(std::uint8_t sub, std::int64_t value) const noexcept {
  if (on()) return AbortCode::unsupported_access;
  if (sub != 0) return count_->value != 0 ? AbortCode::unsupported_access : mappable(value);
  if (value > static_cast<std::int64_t>(max_mapped_objects)) return AbortCode::pdo_length_exceeded;
  unsigned bits = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(value); ++i) {
    const AbortCode code = mappable(entries_[i]->value);
    if (code != AbortCode::none) return code;
    bits += entry_bits(entries_[i]->value);
  }
  return bits <= max_pdo_bits ? AbortCode::none : AbortCode::pdo_length_exceeded;
}

AbortCode SimPdo::mappable(std::int64_t entry) const noexcept {
  const Object* object = objects_.find(entry_address(entry));
  if (object == nullptr) return AbortCode::no_object;
  const bool writable = object->access != ObjectAccess::read_only;
  const bool fits = entry_bits(entry) == 8 * canopen::size_of(object->type) &&
                    (direction() == PdoDirection::transmit || writable);
  return object->mappable && fits ? AbortCode::none : AbortCode::not_mappable;
}

bool SimPdo::on_written(ObjectAddress address) noexcept {
  const bool mapping = address.index == mapping_index(direction(), number());
  if (mapping && address.sub == 0) resolve();
  return mapping || address.index == communication_index(direction(), number());
}

void SimPdo::resolve() noexcept {
  unsigned bits = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count_->value); ++i) {
    mapped_[i] = objects_.find(entry_address(entries_[i]->value));
    bits += entry_bits(entries_[i]->value);
  }
  size_ = static_cast<std::uint8_t>(bits / 8);
}

}  // namespace godobject
