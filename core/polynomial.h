// Fixed-degree polynomials evaluated in parallel pairs (Estrin's scheme): a short dependency chain,
// and the same operations in the same order whatever the argument.
#pragma once

#include <array>
#include <cstddef>

#include "core/types.h"

namespace godobject {

/// c[0] + c[1] x + ... + c[N-1] x^(N-1).
template <std::size_t N>
constexpr Real polynomial(const std::array<Real, N>& c, Real x) noexcept {
  if constexpr (N == 1) {
    return c[0];
  } else {
    std::array<Real, (N + 1) / 2> pairs{};
    for (std::size_t i = 0; i < N / 2; ++i) pairs[i] = c[2 * i] + x * c[2 * i + 1];
    if constexpr (N % 2 == 1) pairs[N / 2] = c[N - 1];
    return polynomial(pairs, x * x);
  }
}

}  // namespace godobject
