// Absolute encoders (CiA 406): position message and related objects.
#pragma once

#include <array>
#include <string_view>

#include "hal/canopen/canopen.h"

namespace godobject::cia406 {

// Objects of the profile.
inline constexpr std::uint16_t operating_parameters = 0x6000;   // u16
inline constexpr std::uint16_t counts_per_revolution = 0x6001;  // u32, effective with scaling on
inline constexpr std::uint16_t total_range = 0x6002;            // u32, modulus; effective with scaling on
inline constexpr std::uint16_t preset_value = 0x6003;           // u32
inline constexpr std::uint16_t position_value = 0x6004;         // u32
inline constexpr std::uint16_t speed_value = 0x6030;            // sub 1, i16
inline constexpr std::uint16_t single_turn_counts = 0x6501;     // u32
inline constexpr std::uint16_t number_of_revolutions = 0x6502;  // u16; modulus 6501h * 6502h without scaling
inline constexpr std::uint16_t alarms = 0x6503;                 // u16, active alarms
inline constexpr std::uint16_t supported_alarms = 0x6504;       // u16
inline constexpr std::uint16_t warnings = 0x6505;               // u16
inline constexpr std::uint16_t supported_warnings = 0x6506;     // u16

inline constexpr std::uint16_t parameter_scaling_on = 1u << 2;  // bit of 6000h

inline constexpr std::uint8_t position_size = 4;
inline constexpr std::uint8_t position_and_speed_size = 6;

/// TPDO1 {6004h:32}: position in counts, 0 .. modulus - 1.
constexpr CanFrame make_position(std::uint8_t node, std::uint32_t position_counts) noexcept {
  CanFrame frame{.id = canopen::tpdo_cob_id(1, node), .size = position_size};
  ByteWriter(frame.data).put(position_counts);
  return frame;
}

[[nodiscard]] constexpr ParseResult parse_position(const CanFrame& frame, std::uint8_t node,
                                                   std::uint32_t& position_counts) noexcept {
  const ParseResult result = canopen::check_message(frame, canopen::tpdo_cob_id(1, node), position_size);
  if (result != ParseResult::ok) return result;
  ByteReader(frame.bytes()).get(position_counts);
  return result;
}

struct PositionAndSpeed {
  std::uint32_t position_counts = 0;
  std::int16_t speed = 0;  // speed in a manufacturer-specific unit
};

/// TPDO1 {6004h:32, 6030h:01:16}.
constexpr CanFrame make_position_and_speed(std::uint8_t node, const PositionAndSpeed& value) noexcept {
  CanFrame frame{.id = canopen::tpdo_cob_id(1, node), .size = position_and_speed_size};
  ByteWriter(frame.data).put(value.position_counts).put(value.speed);
  return frame;
}

[[nodiscard]] constexpr ParseResult parse_position_and_speed(const CanFrame& frame, std::uint8_t node,
                                                             PositionAndSpeed& out) noexcept {
  const ParseResult result =
      canopen::check_message(frame, canopen::tpdo_cob_id(1, node), position_and_speed_size);
  if (result != ParseResult::ok) return result;
  ByteReader(frame.bytes()).get(out.position_counts).get(out.speed);
  return result;
}

/// Text of a bit of 6503h or 6505h.
struct BitText {
  std::uint16_t bit = 0;
  std::string_view meaning;
};

/// Bits of 6503h: the position is not reliable. Bits 2..11 are reserved, 12..15 manufacturer-specific.
inline constexpr std::array alarm_texts{
    BitText{1u << 0, "position error"},
    BitText{1u << 1, "commissioning diagnostics failed"},
};

/// Bits of 6505h: the position is still valid, the encoder needs maintenance. Bits 6..11 are reserved, 12..15
/// manufacturer-specific.
inline constexpr std::array warning_texts{
    BitText{1u << 0, "turns faster than it can count"},
    BitText{1u << 1, "light reserve at its limit"},
    BitText{1u << 2, "CPU watchdog acted"},
    BitText{1u << 3, "operating hours exceeded"},
    BitText{1u << 4, "battery low"},
    BitText{1u << 5, "reference point not reached"},
};

/// Result of checking a preset. Preset 6003h sets the present position to `position_counts`: the coordinate
/// jumps. Allowed only while no torque depends on it.
enum class PresetCheck : std::uint8_t {
  allowed,
  armed,         // disarm first
  out_of_range,  // not below the modulus
};

/// Checks a preset. modulus_counts: modulus of the encoder, counts; 0: 2^32.
constexpr PresetCheck check_preset(std::uint32_t position_counts, std::uint64_t modulus_counts,
                                   bool armed) noexcept {
  if (armed) return PresetCheck::armed;
  return modulus_counts != 0 && position_counts >= modulus_counts ? PresetCheck::out_of_range
                                                                  : PresetCheck::allowed;
}

}  // namespace godobject::cia406
