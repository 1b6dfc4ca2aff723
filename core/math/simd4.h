// Four numbers processed at once: the same quantity of four bodies. Code for a type T processes one body with
// T = Real and four with T = Pack, by the same operations (docs/decisions/016).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#if defined(__AVX__) && !defined(GODOBJECT_REAL)
#include <immintrin.h>
#endif

#include "core/math/types.h"

namespace godobject {

/// Applies f to the parts of both arguments.
template <class R, class A, class F>
R apply_by_parts(const A& a, const A& b, F f) noexcept {
  R r;
  for (std::size_t k = 0; k < a.parts.size(); ++k) r.parts[k] = f(a.parts[k], b.parts[k]);
  return r;
}

/// Four numbers in vectors of the processor's size: one of four numbers, or two of two.
struct Pack {
#if defined(__AVX__) && !defined(GODOBJECT_REAL)
  static constexpr std::size_t num_parts = 1;
  using Part [[gnu::vector_size(32)]] = Real;
#else
  static constexpr std::size_t num_parts = 2;
  using Part [[gnu::vector_size(2 * sizeof(Real))]] = Real;
#endif
  static constexpr std::size_t size = 4;
  static constexpr std::size_t part_size = size / num_parts;
  std::array<Part, num_parts> parts;

  Pack() = default;
  Pack(Real a) noexcept : Pack(a, a, a, a) {}
  Pack(Real a, Real b, Real c, Real d) noexcept {
#if defined(__AVX__) && !defined(GODOBJECT_REAL)
    parts = {Part{a, b, c, d}};
#else
    parts = {Part{a, b}, Part{c, d}};
#endif
  }
  Real operator[](std::size_t j) const noexcept { return parts[j / part_size][j % part_size]; }
  void set(std::size_t j, Real a) noexcept { parts[j / part_size][j % part_size] = a; }

  Pack& operator+=(const Pack& b) noexcept { return *this = *this + b; }
  Pack& operator-=(const Pack& b) noexcept { return *this = *this - b; }
  Pack& operator*=(const Pack& b) noexcept { return *this = *this * b; }
  Pack& operator/=(const Pack& b) noexcept { return *this = *this / b; }

  friend Pack operator+(const Pack& a, const Pack& b) noexcept {
    return apply_by_parts<Pack>(a, b, [](Part x, Part y) { return x + y; });
  }
  friend Pack operator-(const Pack& a, const Pack& b) noexcept {
    return apply_by_parts<Pack>(a, b, [](Part x, Part y) { return x - y; });
  }
  friend Pack operator*(const Pack& a, const Pack& b) noexcept {
    return apply_by_parts<Pack>(a, b, [](Part x, Part y) { return x * y; });
  }
  friend Pack operator/(const Pack& a, const Pack& b) noexcept {
    return apply_by_parts<Pack>(a, b, [](Part x, Part y) { return x / y; });
  }
  friend Pack operator-(const Pack& a) noexcept {
    return apply_by_parts<Pack>(a, a, [](Part x, Part) { return -x; });
  }
};

/// Condition for each of four numbers.
struct PackMask {
  using Part = decltype(Pack::Part{} < Pack::Part{});
  std::array<Part, Pack::num_parts> parts;
};
inline PackMask operator<(const Pack& a, const Pack& b) noexcept {
  return apply_by_parts<PackMask>(a, b, [](auto x, auto y) { return x < y; });
}
inline PackMask operator<=(const Pack& a, const Pack& b) noexcept {
  return apply_by_parts<PackMask>(a, b, [](auto x, auto y) { return x <= y; });
}
inline PackMask operator>(const Pack& a, const Pack& b) noexcept { return b < a; }

/// Returns `yes` where the condition holds, else `no`. Both are evaluated.
inline Real select(bool condition, Real yes, Real no) noexcept { return condition ? yes : no; }
inline Pack select(const PackMask& condition, const Pack& yes, const Pack& no) noexcept {
  Pack r;
  for (std::size_t k = 0; k < Pack::num_parts; ++k)
    r.parts[k] = condition.parts[k] ? yes.parts[k] : no.parts[k];
  return r;
}

/// Selects by component of a vector.
template <class Condition, class T>
Eigen::Matrix<T, 3, 1> select(const Condition& condition, const Eigen::Matrix<T, 3, 1>& yes,
                              const Eigen::Matrix<T, 3, 1>& no) noexcept {
  return {select(condition, yes[0], no[0]), select(condition, yes[1], no[1]),
          select(condition, yes[2], no[2])};
}

/// Returns a word whose bit j is set if the condition holds for number j.
inline std::uint32_t bits(const PackMask& m) noexcept {
#if defined(__AVX__) && !defined(GODOBJECT_REAL)
  return static_cast<std::uint32_t>(_mm256_movemask_pd(std::bit_cast<__m256d>(m.parts[0])));
#else
  std::uint32_t b = 0;
  for (std::size_t j = 0; j < Pack::size; ++j)
    b |= (m.parts[j / Pack::part_size][j % Pack::part_size] != 0 ? 1u : 0u) << j;
  return b;
#endif
}
inline PackMask operator&(const PackMask& a, const PackMask& b) noexcept {
  return apply_by_parts<PackMask>(a, b, [](auto x, auto y) { return x & y; });
}

inline PackMask operator|(const PackMask& a, const PackMask& b) noexcept {
  return apply_by_parts<PackMask>(a, b, [](auto x, auto y) { return x | y; });
}

/// True if the condition holds for any number.
inline bool any(bool condition) noexcept { return condition; }
inline bool any(const PackMask& m) noexcept { return bits(m) != 0; }

inline Pack max(const Pack& a, const Pack& b) noexcept { return select(a < b, b, a); }
inline Pack abs(const Pack& a) noexcept { return max(a, -a); }
inline Pack min(const Pack& a, const Pack& b) noexcept { return select(b < a, b, a); }
inline Real max(Real a, Real b) noexcept { return std::max(a, b); }
inline Real min(Real a, Real b) noexcept { return std::min(a, b); }
inline Real largest(const Pack& a) noexcept { return std::max(std::max(a[0], a[1]), std::max(a[2], a[3])); }
inline Real total(const Pack& a) noexcept { return (a[0] + a[1]) + (a[2] + a[3]); }
inline Pack sqrt(const Pack& a) noexcept {
#if defined(__AVX__) && !defined(GODOBJECT_REAL)
  Pack r;
  r.parts[0] = _mm256_sqrt_pd(a.parts[0]);
  return r;
#else
  return {std::sqrt(a[0]), std::sqrt(a[1]), std::sqrt(a[2]), std::sqrt(a[3])};
#endif
}

/// Returns numbers i, j, k, l of the eight of a and b.
template <int i, int j, int k, int l>
Pack shuffled(const Pack& a, const Pack& b) noexcept {
#if defined(__AVX__) && !defined(GODOBJECT_REAL)
  Pack r;
  r.parts[0] = __builtin_shufflevector(a.parts[0], b.parts[0], i, j, k, l);
  return r;
#else
  const auto at = [&](int n) {
    return n < 4 ? a[static_cast<std::size_t>(n)] : b[static_cast<std::size_t>(n - 4)];
  };
  return {at(i), at(j), at(k), at(l)};
#endif
}

template <class T>
inline constexpr std::size_t num_lanes = 1;
template <>
inline constexpr std::size_t num_lanes<Pack> = Pack::size;

/// Returns lane j of a pack; a single number is returned as it is.
inline Real lane(Real a, std::size_t) noexcept { return a; }
inline Real lane(const Pack& a, std::size_t j) noexcept { return a[j]; }
template <class T>
Vec3 lane(const Eigen::Matrix<T, 3, 1>& a, std::size_t j) noexcept {
  return {lane(a[0], j), lane(a[1], j), lane(a[2], j)};
}
template <class T>
Mat3 lane(const Eigen::Matrix<T, 3, 3>& a, std::size_t j) noexcept {
  Mat3 all;
  for (int k = 0; k < 9; ++k) all.data()[k] = lane(a.data()[k], j);
  return all;
}
template <class T>
Quat lane(const Eigen::Quaternion<T, Eigen::DontAlign>& q, std::size_t j) noexcept {
  return {lane(q.w(), j), lane(q.x(), j), lane(q.y(), j), lane(q.z(), j)};
}
template <class T>
Pose lane(const PoseOf<T>& X, std::size_t j) noexcept {
  return {.p = lane(X.p, j), .q = lane(X.q, j)};
}

/// Replaces number j.
inline void set_lane(Real& a, std::size_t, Real value) noexcept { a = value; }
inline void set_lane(Pack& a, std::size_t j, Real value) noexcept { a.set(j, value); }
template <class T>
void set_lane(Eigen::Matrix<T, 3, 1>& a, std::size_t j, const Vec3& value) noexcept {
  for (int c = 0; c < 3; ++c) set_lane(a[c], j, value[c]);
}

}  // namespace godobject

namespace Eigen {

template <>
struct NumTraits<godobject::Pack> : NumTraits<godobject::Real> {
  using Real = godobject::Pack;
  using NonInteger = godobject::Pack;
  using Nested = godobject::Pack;
  using Literal = godobject::Real;
  enum { RequireInitialization = 0 };
};
template <class Operation>
struct ScalarBinaryOpTraits<godobject::Real, godobject::Pack, Operation> {
  using ReturnType = godobject::Pack;
};
template <class Operation>
struct ScalarBinaryOpTraits<godobject::Pack, godobject::Real, Operation> {
  using ReturnType = godobject::Pack;
};

}  // namespace Eigen
