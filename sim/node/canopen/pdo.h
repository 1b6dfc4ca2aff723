// PDO of a simulated node: its communication and mapping records in the object dictionary, the rules of CiA
// 301 7.5.2 for changing them, and its frames.
#pragma once

#include <vector>

#include "hal/canopen/pdo_map.h"
#include "sim/node/canopen/object_dictionary.h"

namespace godobject {

/// Transmission type: sent when an object changes or by the event timer (CiA 301).
inline constexpr std::uint8_t event_driven = 255;

/// Configuration of a PDO after power-up.
struct SimPdoDefault {
  PdoDirection direction = PdoDirection::transmit;
  int number = 1;  // 1..4
  bool on = true;
  std::uint8_t transmission = 1;
  std::uint16_t timer_ms = 0;  // event timer of a TPDO, deadline of an RPDO; 0: none
  std::vector<canopen::ObjectAddress> map{};
};

class SimPdo {
 public:
  /// Adds the records to `objects`, which outlives the PDO and must contain the mapped objects.
  SimPdo(ObjectDictionary& objects, SimPdoDefault power_up);

  /// Restores the power-up configuration.
  void reset(std::uint8_t node_id) noexcept;

  PdoDirection direction() const noexcept { return power_up_.direction; }
  int number() const noexcept { return power_up_.number; }
  bool on() const noexcept { return (cob_id_->value & SdoSequence::pdo_invalid) == 0; }
  std::uint32_t cob_id() const noexcept { return static_cast<std::uint32_t>(cob_id_->value) & 0x7FFu; }
  std::uint8_t transmission() const noexcept { return static_cast<std::uint8_t>(transmission_->value); }
  bool synchronous() const noexcept { return transmission() <= max_synchronous; }
  Nanoseconds timer_ns() const noexcept { return 1'000'000 * timer_ms_->value; }
  std::uint8_t size() const noexcept { return size_; }

  /// Packs the values of the mapped objects.
  CanFrame pack() const noexcept;
  /// Writes a frame of size() bytes into the mapped objects.
  void unpack(const CanFrame& frame) noexcept;

  /// Returns the abort code of a write to an object of this PDO's records; AbortCode::none if allowed or not
  /// its object.
  sdo::AbortCode may_write(canopen::ObjectAddress address, std::int64_t value) const noexcept;
  /// Returns true if the object belongs to this PDO's records.
  bool on_written(canopen::ObjectAddress address) noexcept;

  // State of the node's timers.
  int syncs_since_sent = 0;
  Nanoseconds t_timer_ns = 0;  // time of the next event
  CanFrame pending;            // an RPDO that waits for SYNC
  bool has_pending = false;

 private:
  static constexpr std::uint8_t max_synchronous = 240;

  sdo::AbortCode may_write_communication(std::uint8_t sub, std::int64_t value) const noexcept;
  sdo::AbortCode may_write_mapping(std::uint8_t sub, std::int64_t value) const noexcept;
  sdo::AbortCode mappable(std::int64_t entry) const noexcept;
  void resolve() noexcept;

  ObjectDictionary& objects_;
  SimPdoDefault power_up_;
  Object *cob_id_, *transmission_, *inhibit_, *timer_ms_, *count_;
  std::array<Object*, max_mapped_objects> entries_{};
  std::array<Object*, max_mapped_objects> mapped_{};  // the first count_ are used
  std::uint8_t size_ = 0;                             // bytes
};

}  // namespace godobject
