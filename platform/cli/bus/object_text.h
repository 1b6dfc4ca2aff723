// Objects of a CANopen dictionary as a person writes and reads them.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/canopen/object.h"

namespace godobject {

/// "6077", "6077h", "0x6077", with or without ":00": all hexadecimal, as manuals have them.
std::optional<canopen::ObjectAddress> parse_object_address(std::string_view text);

/// What --type can be: the names of ObjectType, and "hex".
std::vector<std::string> value_type_names();

/// The type of this name where its values are numbers.
std::optional<canopen::ObjectType> number_type(const std::string& name);

/// The bytes of a value of this type; `error` says what is wrong with the text. hex: "0A 00" or "0A00".
std::optional<std::vector<std::uint8_t>> parse_value(std::string_view text, const std::string& type,
                                                     std::string& error);

/// The bytes as a value of this type; without one (empty) as every type they may be. `error` says why the
/// bytes cannot be of the type.
std::optional<std::string> format_value(std::span<const std::uint8_t> bytes, const std::string& type,
                                        std::string& error);

}  // namespace godobject
