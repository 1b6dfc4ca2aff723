// Checks of option values: CLI11's own let NaN through and do not say what is admissible.
#pragma once

#include <CLI/CLI.hpp>

namespace godobject {

/// A number from min to max, both admissible.
CLI::Validator number_in(double min, double max);
/// A number above min and up to max.
CLI::Validator number_above(double min, double max);
/// A port of TCP, or nothing.
CLI::Validator port_number();

}  // namespace godobject
