// Checks of option values: CLI11's own let NaN through and do not say what is admissible.
#pragma once

#include <charconv>
#include <string>

#include <CLI/CLI.hpp>

#include "sim/key.h"

namespace godobject {

/// A number within the range.
inline CLI::Validator number_in(const Range& range) {
  const auto check = [range](const std::string& text) -> std::string {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool number = error == std::errc() && end == text.data() + text.size();
    return number && range.contains(value) ? "" : "'" + text + "' is not a number " + to_string(range);
  };
  return {check, to_string(range), "number"};
}

}  // namespace godobject
