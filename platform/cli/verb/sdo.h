// Text form of the objects of a CANopen dictionary, for `godobject sdo`.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/canopen/object.h"

namespace godobject {

/// Parses "6077", "6077h" or "0x6077", each with or without ":00". All are hexadecimal, as in manuals.
std::optional<canopen::ObjectAddress> parse_object_address(std::string_view text);

/// Returns the values of --type: the names of ObjectType, and "hex".
std::vector<std::string> value_type_names();

/// Returns the type of this name if its values are numbers.
std::optional<canopen::ObjectType> number_type(const std::string& name);

/// Returns the bytes of a value of this type; "hex" accepts "0A 00" or "0A00". On failure sets `error`.
std::optional<std::vector<std::uint8_t>> parse_value(std::string_view text, const std::string& type,
                                                     std::string& error);

/// Formats the bytes as a value of this type, or, with an empty type, as every type of their size. Sets
/// `error` if the bytes cannot be of the type.
std::optional<std::string> format_value(std::span<const std::uint8_t> bytes, const std::string& type,
                                        std::string& error);

}  // namespace godobject
