// Which frames a receiver wants of a bus.
#pragma once

#include <algorithm>
#include <span>

#include "hal/can/frame.h"

namespace godobject {

/// Identifiers that a receiver wants: id passes where (id & mask) == (wanted & mask).
struct CanFilter {
  std::uint32_t id = 0;
  std::uint32_t mask = 0;
  bool extended = false;
};

/// Whether a receiver with these filters gets the frame.
constexpr bool passes(std::span<const CanFilter> filters, const CanFrame& frame) noexcept {
  const auto wants = [&](const CanFilter& filter) {
    return filter.extended == frame.extended && (frame.id & filter.mask) == (filter.id & filter.mask);
  };
  return filters.empty() || std::ranges::any_of(filters, wants);
}

}  // namespace godobject
