// Polynomials of fixed degree, evaluated in parallel pairs (Estrin's scheme). Short dependency chain, and the
// same operations in the same order for any argument.
#pragma once

#include <array>
#include <cstddef>

#include "core/math/simd4.h"

namespace godobject {

/// Returns c[0] + c[1] x + ... + c[N-1] x^(N-1).
template <class T, class C, std::size_t N>
constexpr T polynomial(const std::array<C, N>& c, const T& x) noexcept {
  if constexpr (N == 1) {
    return c[0];
  } else {
    std::array<T, (N + 1) / 2> pairs{};
    for (std::size_t i = 0; i < N / 2; ++i) pairs[i] = c[2 * i] + x * c[2 * i + 1];
    if constexpr (N % 2 == 1) pairs[N / 2] = c[N - 1];
    return polynomial<T>(pairs, x * x);
  }
}

}  // namespace godobject
