#include "sim/node/canopen/object_dictionary.h"

#include <algorithm>

namespace godobject {

using canopen::ObjectAddress;
using canopen::ObjectType;
using sdo::AbortCode;

Object& ObjectDictionary::add(ObjectAddress address, ObjectType type, ObjectAccess access,
                              std::int64_t value) {
  Object& object = objects_[address];
  object = {.type = type,
            .access = access,
            .value = value,
            .power_up = value,
            .low = canopen::lowest(type),
            .high = canopen::highest(type)};
  return object;
}

Object& ObjectDictionary::add_text(ObjectAddress address, std::string text) {
  Object& object = objects_[address];
  object = {.type = ObjectType::text, .text = std::move(text)};
  return object;
}

Object& ObjectDictionary::add_mappable(ObjectAddress address, ObjectType type, ObjectAccess access,
                                       std::int64_t value) {
  Object& object = add(address, type, access, value);
  object.mappable = true;
  return object;
}

void ObjectDictionary::reset(std::uint16_t first, std::uint16_t last) noexcept {
  for (auto& [address, object] : objects_)
    if (address.index >= first && address.index <= last) object.value = object.power_up;
}

Object* ObjectDictionary::find(ObjectAddress address) noexcept {
  const auto found = objects_.find(address);
  return found == objects_.end() ? nullptr : &found->second;
}

const Object* ObjectDictionary::find(ObjectAddress address) const noexcept {
  const auto found = objects_.find(address);
  return found == objects_.end() ? nullptr : &found->second;
}

std::int64_t ObjectDictionary::value(ObjectAddress address) const noexcept {
  const Object* object = find(address);
  return object == nullptr ? 0 : object->value;
}

AbortCode ObjectDictionary::absent(ObjectAddress address) const noexcept {
  const auto same_index = objects_.lower_bound({address.index, 0});
  const bool known = same_index != objects_.end() && same_index->first.index == address.index;
  return known ? AbortCode::no_sub_index : AbortCode::no_object;
}

AbortCode ObjectDictionary::read(ObjectAddress address, std::span<std::uint8_t> out,
                                 std::size_t& size) noexcept {
  const Object* object = find(address);
  if (object == nullptr) return absent(address);
  if (object->access == ObjectAccess::write_only) return AbortCode::write_only;
  observer_.before_read();
  if (object->type == ObjectType::text) {
    size = std::min(out.size(), object->text.size());
    std::copy_n(object->text.begin(), size, out.begin());
    return AbortCode::none;
  }
  size = std::min(out.size(), canopen::size_of(object->type));
  canopen::encode_number(object->value, out.first(size));
  return AbortCode::none;
}

AbortCode ObjectDictionary::write(ObjectAddress address, std::span<const std::uint8_t> bytes) noexcept {
  Object* object = find(address);
  if (object == nullptr) return absent(address);
  if (object->access == ObjectAccess::read_only) return AbortCode::read_only;
  const std::size_t size = canopen::size_of(object->type);
  if (bytes.size() > size) return AbortCode::too_long;
  if (bytes.size() < size) return AbortCode::too_short;
  const std::int64_t value = canopen::decode_number(bytes, canopen::is_signed(object->type));
  if (value > object->high) return AbortCode::value_too_high;
  if (value < object->low) return AbortCode::value_too_low;
  const AbortCode veto = observer_.may_write(address, value);
  if (veto != AbortCode::none) return veto;
  object->value = value;
  observer_.on_written(address, value);
  return AbortCode::none;
}

}  // namespace godobject
