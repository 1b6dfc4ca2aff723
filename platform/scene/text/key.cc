#include "platform/scene/text/key.h"

#include <array>
#include <charconv>
#include <cmath>

namespace godobject {

namespace {

std::string plain(double x) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), x).ptr;
  return {text.data(), end};
}

}  // namespace

std::string to_string(const Range& range) {
  const bool has_min = std::isfinite(range.min), has_max = std::isfinite(range.max);
  if (has_min && has_max) {
    return range.min_open ? "> " + plain(range.min) + " and <= " + plain(range.max)
                          : plain(range.min) + " to " + plain(range.max);
  }
  if (has_min) return (range.min_open ? "> " : ">= ") + plain(range.min);
  return has_max ? "<= " + plain(range.max) : "";
}

std::string shortest(double x) {
  std::string text = plain(x);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

}  // namespace godobject
