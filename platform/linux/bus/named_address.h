// Option values with a name: "can0=socketcan:vcan0", "polaris=/dev/ttyUSB0".
#pragma once

#include <string>

namespace godobject {

struct NamedAddress {
  std::string name;  // empty: an address alone
  std::string address;
};

/// Splits NAME=ADDRESS. of_addresses: a character that occurs in addresses and not in names; a '=' after it
/// belongs to the address.
inline NamedAddress split_name(const std::string& text, char of_addresses) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || text.find(of_addresses) < equals) return {.name = "", .address = text};
  return {.name = text.substr(0, equals), .address = text.substr(equals + 1)};
}

/// Returns "'can0', 'can1'", for messages.
template <class Named>
std::string quoted_names(const Named& all) {
  std::string names;
  for (const auto& one : all) names += (names.empty() ? "'" : ", '") + one.name + "'";
  return names;
}

}  // namespace godobject
