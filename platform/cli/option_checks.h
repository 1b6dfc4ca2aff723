// Checks of option values. Those of CLI11 accept NaN and do not name the admissible values.
#pragma once

#include <CLI/CLI.hpp>

namespace godobject {

/// Requires a number in [min, max].
CLI::Validator number_in(double min, double max);
/// Requires a number in (min, max].
CLI::Validator number_above(double min, double max);
/// Requires a TCP port, or an empty text.
CLI::Validator port_number();

}  // namespace godobject
