// PDO mapping (CiA 301 7.5.2): named objects, and the steps that configure a PDO.
#pragma once

#include <optional>
#include <string_view>

#include "hal/canopen/node_profile.h"
#include "hal/canopen/sdo/sequence.h"

namespace godobject {

inline constexpr std::size_t max_mapped_objects = 8;
inline constexpr unsigned max_pdo_bits = 64;

struct NamedObject {
  std::string_view name;
  canopen::ObjectAddress address;
  std::uint8_t bits;
};

/// Returns the objects that a profile's map can name: objects of CiA 402 and CiA 406.
std::span<const NamedObject> named_objects() noexcept;

/// Parses an object by name, or as "6077h:00:16": index and sub-index (hexadecimal), length in bits.
std::optional<MappedObject> parse_mapped_object(std::string_view text) noexcept;

/// Returns the error in the map of a PDO (too many objects or bits); empty if valid.
std::string map_error(const PdoProfile& pdo);

/// Returns the entry of a mapping record: index, sub-index, length (CiA 301 figure 78).
constexpr std::uint32_t mapping_entry(const MappedObject& object) noexcept {
  return std::uint32_t{object.address.index} << 16 | std::uint32_t{object.address.sub} << 8 | object.bits;
}

/// Returns the first index of the communication and mapping records; PDO n has index + n - 1.
constexpr std::uint16_t communication_index(PdoDirection direction, int number) noexcept {
  return static_cast<std::uint16_t>((direction == PdoDirection::receive ? 0x1400 : 0x1800) + number - 1);
}
constexpr std::uint16_t mapping_index(PdoDirection direction, int number) noexcept {
  return static_cast<std::uint16_t>((direction == PdoDirection::receive ? 0x1600 : 0x1A00) + number - 1);
}
constexpr std::uint32_t default_cob_id(PdoDirection direction, int number, std::uint8_t node) noexcept {
  return direction == PdoDirection::receive ? canopen::rpdo_cob_id(number, node)
                                            : canopen::tpdo_cob_id(number, node);
}

/// Appends the steps of a remap, then reads each value back. transmission: value of xx:02. All devices accept
/// only this order: switch off, count 0, entries, count, transmission type and times, switch on.
void append_map_steps(const PdoProfile& pdo, std::uint8_t node, std::uint8_t transmission,
                      std::vector<SdoStep>& steps);

/// Appends steps that compare the PDO with its required configuration and remap it only if it differs. Only
/// differing values are written, because some devices have read-only maps.
void append_pdo_steps(const PdoProfile& pdo, std::uint8_t node, std::uint8_t transmission,
                      std::vector<SdoStep>& steps);

/// Appends steps that switch off the TPDOs 1..4 missing in the profile. Otherwise factory mappings load the
/// bus and answer to SYNC.
void append_switch_off_steps(const std::vector<PdoProfile>& kept, std::vector<SdoStep>& steps);

}  // namespace godobject
