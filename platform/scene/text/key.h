// A key of a scene file: name, unit, admissible range and meaning. Reader, writer and reference of the format
// are three visitors of the keys in platform/scene/keys/scene.h.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <string_view>

#include "hal/base/format.h"

namespace godobject {

/// Admissible numbers; both ends are included, except min if min_open.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_open = false;

  bool contains(double x) const { return (min_open ? x > min : x >= min) && x <= max; }
};

inline constexpr Range any_number{};
inline constexpr Range not_negative{0};
inline constexpr Range positive{.min = 0, .min_open = true};
inline constexpr Range probability{0, 1};

struct Key {
  std::string_view name;
  std::string_view unit;  // empty: none
  std::string_view meaning;
  Range range = any_number;
  bool required = false;
  std::string_view otherwise = {};  // text of the default if it depends on other keys
};

struct TableKey {
  std::string_view name;
  std::string_view meaning;
  bool required = false;
  // largest number of tables in an array, since rules between them may take quadratic time
  std::size_t max = 1000;
};

/// Returns ">= 0", "> 0" or "0 to 1"; empty for any number.
std::string to_string(const Range& range);

}  // namespace godobject
