// The object dictionary of a simulated CANopen node: what SDO reads and writes, and what PDOs map.
#pragma once

#include <map>
#include <string>

#include "hal/canopen/sdo/sdo.h"

namespace godobject {

enum class ObjectAccess : std::uint8_t { read_only, write_only, read_write };

struct Object {
  canopen::ObjectType type = canopen::ObjectType::u32;
  ObjectAccess access = ObjectAccess::read_only;
  bool mappable = false;
  std::int64_t value = 0;          // within its type
  std::int64_t power_up = 0;       // value after a reset
  std::int64_t low = 0, high = 0;  // admissible in a write
  std::string text{};              // of ObjectType::text
};

/// Asked before a value is written by SDO, told after it.
class ObjectObserver {
 public:
  virtual ~ObjectObserver() = default;
  /// Type, access and range are right already. AbortCode::none lets it pass.
  virtual sdo::AbortCode may_write(canopen::ObjectAddress address, std::int64_t value) noexcept = 0;
  virtual void on_written(canopen::ObjectAddress address, std::int64_t value) noexcept = 0;
  /// Objects that show what happens now are brought up to date.
  virtual void before_read() noexcept = 0;
};

class ObjectDictionary {
 public:
  explicit ObjectDictionary(ObjectObserver& observer) noexcept : observer_(observer) {}

  // Set-up: allocates. The reference stays valid as long as the dictionary. Ranges are those of the type.
  Object& add(canopen::ObjectAddress address, canopen::ObjectType type, ObjectAccess access,
              std::int64_t value = 0);
  Object& add_text(canopen::ObjectAddress address, std::string text);
  /// Read-write and mappable.
  Object& add_mappable(canopen::ObjectAddress address, canopen::ObjectType type,
                       ObjectAccess access = ObjectAccess::read_write, std::int64_t value = 0);

  /// Objects of index first..last get the value they were added with.
  void reset(std::uint16_t first, std::uint16_t last) noexcept;

  /// Null where there is none.
  Object* find(canopen::ObjectAddress address) noexcept;
  const Object* find(canopen::ObjectAddress address) const noexcept;
  /// 0 where there is none.
  std::int64_t value(canopen::ObjectAddress address) const noexcept;

  /// What an SDO upload does: bytes to `out`, their number to `size`; a value that has no room is cut.
  sdo::AbortCode read(canopen::ObjectAddress address, std::span<std::uint8_t> out,
                      std::size_t& size) noexcept;
  /// What an SDO download does.
  sdo::AbortCode write(canopen::ObjectAddress address, std::span<const std::uint8_t> bytes) noexcept;

 private:
  sdo::AbortCode absent(canopen::ObjectAddress address) const noexcept;

  ObjectObserver& observer_;
  std::map<canopen::ObjectAddress, Object> objects_;
};

}  // namespace godobject
