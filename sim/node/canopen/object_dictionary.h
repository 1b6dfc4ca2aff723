// Object dictionary of a simulated CANopen node: read and written by SDO, mapped by PDOs.
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
  std::int64_t low = 0, high = 0;  // admissible range of a write
  std::string text{};              // for ObjectType::text
};

/// Called before and after an SDO write.
class ObjectObserver {
 public:
  virtual ~ObjectObserver() = default;
  /// Returns AbortCode::none to accept the value. Type, access and range were checked.
  virtual sdo::AbortCode may_write(canopen::ObjectAddress address, std::int64_t value) noexcept = 0;
  virtual void on_written(canopen::ObjectAddress address, std::int64_t value) noexcept = 0;
  /// Updates objects that show present values.
  virtual void before_read() noexcept = 0;
};

class ObjectDictionary {
 public:
  explicit ObjectDictionary(ObjectObserver& observer) noexcept : observer_(observer) {}

  // Set-up: allocates. References stay valid during the life of the dictionary. Ranges are those of the type.
  Object& add(canopen::ObjectAddress address, canopen::ObjectType type, ObjectAccess access,
              std::int64_t value = 0);
  Object& add_text(canopen::ObjectAddress address, std::string text);
  /// Adds a mappable object, by default read-write.
  Object& add_mappable(canopen::ObjectAddress address, canopen::ObjectType type,
                       ObjectAccess access = ObjectAccess::read_write, std::int64_t value = 0);

  /// Restores the initial values of the objects of index first..last.
  void reset(std::uint16_t first, std::uint16_t last) noexcept;

  /// Returns the object; null if it does not exist.
  Object* find(canopen::ObjectAddress address) noexcept;
  const Object* find(canopen::ObjectAddress address) const noexcept;
  /// Returns the value; 0 if the object does not exist.
  std::int64_t value(canopen::ObjectAddress address) const noexcept;

  /// Performs an SDO upload: bytes to `out`, their number to `size`; a value longer than `out` is truncated.
  sdo::AbortCode read(canopen::ObjectAddress address, std::span<std::uint8_t> out,
                      std::size_t& size) noexcept;
  /// Performs an SDO download.
  sdo::AbortCode write(canopen::ObjectAddress address, std::span<const std::uint8_t> bytes) noexcept;

 private:
  sdo::AbortCode absent(canopen::ObjectAddress address) const noexcept;

  ObjectObserver& observer_;
  std::map<canopen::ObjectAddress, Object> objects_;
};

}  // namespace godobject
