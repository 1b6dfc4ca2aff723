// Lines of candump's log format: "(1631416514.717133) can0 0D2#0000FFFF10000000".
//   (seconds.microseconds) interface ID#DATA    classic; three digits of ID: standard, eight: extended
//   ... ID#R or ID#R<size>                      remote
//   ... ID#DATA_<DLC> or ID#R8_<DLC>            8 bytes; DLC 9 to F also means 8 bytes and is dropped
//   ... ID##<flags>DATA                         FD; flag 1: bit-rate switch, 2: error state, 4: FD
// The fraction is written with six digits, because older can-utils misread any other count. It is read with
// six or nine digits. Names of several interfaces are padded with spaces to the longest.
#pragma once

#include <span>
#include <string_view>

#include "hal/can/frame.h"

namespace godobject {

enum class CandumpResult : std::uint8_t {
  ok,
  ignored,           // parse: the line does not begin with "("; readers skip it
  bad_time,          // parse: not "(digits.six or nine digits)"; format: negative
  bad_interface,     // missing, longer than 15 characters, or contains white space
  bad_identifier,    // not three or eight hexadecimal digits, or out of range
  bad_data,          // odd number of digits, not hexadecimal, or a size or DLC that the format does not have
  error_frame,       // parse: error report of a controller, which is no frame on the wire
  buffer_too_small,  // format
};

/// Longest line (FD frame of 64 bytes) without line end, characters.
inline constexpr std::size_t max_candump_line = 192;

/// Writes the line without line end to `out` and its length to `length`. Time is truncated to microseconds.
[[nodiscard]] CandumpResult format_candump(const ReceivedFrame& received, std::string_view interface,
                                           std::span<char> out, std::size_t& length) noexcept;

/// Parses a line, with or without line end and direction (" R" or " T", appended by some writers). interface:
/// points into `line`. Outputs are written on `ok` only. The FD error state indicator is dropped.
[[nodiscard]] CandumpResult parse_candump(std::string_view line, ReceivedFrame& received,
                                          std::string_view& interface) noexcept;

}  // namespace godobject
