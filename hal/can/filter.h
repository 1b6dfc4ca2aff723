// Acceptance filters of a receiver.
#pragma once

#include <algorithm>
#include <span>

#include "hal/can/frame.h"

namespace godobject {

/// Acceptance filter: a frame passes if (frame.id & mask) == (id & mask).
struct CanFilter {
  std::uint32_t id = 0;
  std::uint32_t mask = 0;
  bool extended = false;
};

/// True if a receiver with these filters receives the frame. Without filters every frame passes.
constexpr bool passes(std::span<const CanFilter> filters, const CanFrame& frame) noexcept {
  const auto accepts = [&](const CanFilter& filter) {
    return filter.extended == frame.extended && (frame.id & filter.mask) == (filter.id & filter.mask);
  };
  return filters.empty() || std::ranges::any_of(filters, accepts);
}

}  // namespace godobject
