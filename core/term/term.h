// Terms: forces between bodies and the world, as effective masses and impulses in the block system (26).
//
//   using Terms = TermList<DampedSprings<4>, CoordinateSprings<2>>;
//
// Kinds of terms are a file each, such as damped_spring.h; this file has the list of the kinds of a scene.
// Members of a kind:
//   max             capacity for its terms
//   max_ends        largest number of bodies of a term
//   on_coordinates  true if it acts on coordinates of joints
//   is_joint        true if its bodies become one tool, whose bodies do not touch each other
//   Param, Stage    parameters of a term, and its data in a stage
//   ends()          bodies that it couples
//   begin()         linearises it about the predicted end of the stage
//   load()          adds it to the block system
//   each_impulse()  its impulses at the velocities of the end
//   force()         impulse on its last end, about its point
#pragma once

#include <algorithm>
#include <tuple>

#include "core/composition.h"
#include "core/joint/edges.h"

namespace godobject {

/// Bodies that a term couples, by number, each once.
struct TermEnds {
  static constexpr std::size_t max = 4, max_pairs = max * (max - 1) / 2;
  static constexpr std::uint32_t on_world = ~std::uint32_t(0);
  std::array<std::uint32_t, max> list{};
  std::uint32_t size = 0;

  /// Returns the place of u in the list, appended if it is new.
  std::uint32_t add(std::uint32_t u) noexcept {
    const auto end = list.begin() + size;
    const auto at = std::find(list.begin(), end, u);
    if (at == end) list[size++] = u;
    return static_cast<std::uint32_t>(at - list.begin());
  }
  bool contains(std::uint32_t u) const noexcept {
    return std::find(list.begin(), list.begin() + size, u) != list.begin() + size;
  }
  /// Calls f(a, b) for every two places a < b of the list.
  template <class F>
  void each_pair(F f) const noexcept {
    for (std::uint32_t a = 0; a < size; ++a)
      for (std::uint32_t b = a + 1; b < size; ++b) f(a, b);
  }
};

/// Entries of the block system, one for every two ends, in the order of each_pair().
using TermEntries = std::array<std::uint32_t, TermEnds::max_pairs>;

/// Term in the graph of coupled bodies. Undefined between steps.
struct TermEdge : TermEnds {
  std::uint32_t island = 0;
  TermEntries entries{};
};

/// Coordinate of a joint at the predicted end of a stage.
struct CoordinateAt {
  Real q = 0, rate = 0;     // rad or m, turns counted, and its derivative
  Vec3 s_W = Vec3::Zero();  // axis, unit
  Vec3 a_W = Vec3::Zero();  // anchor on the child
  bool is_turn = true;      // true for a rotation
  std::uint32_t child = 0, parent = TermEnds::on_world;

  /// Returns the covector a of the coordinate's rate, a . V, for the twist V of the child at its centre of
  /// mass p. For the parent at p, -a.
  SpatialVector row(const Vec3& p_W) const noexcept {
    if (is_turn) return {.w = Column(s_W), .v = Column(Pack(0))};
    return {.w = Column(Vec3((a_W - p_W).cross(s_W))), .v = Column(s_W)};
  }
};

/// Stage as terms use it. at[u]: predicted place of u at the end of the stage. stages[u]: its effective mass.
/// coordinate(i, c): coordinate c of the joint of body i.
template <class Places, class Stages, class CoordinateOf>
struct TermStage {
  const Places& at;
  const Stages& stages;
  const CoordinateOf& coordinate;
  Real h;
};

/// Terms of one kind, up to its capacity.
template <class T, std::size_t max>
struct TermArray {
  std::array<T, max> list;
  std::size_t size = 0;
};

/// Wrench of each term on its last end about its point, world axes. For terms on coordinates, the force along
/// the last one.
template <std::size_t max>
struct TermForces {
  std::array<Wrench, max> list;
};

/// Terms part of a scene.
template <class... Kinds>
struct TermList {
  static constexpr std::size_t max_terms = (Kinds::max + ... + 0);
  static constexpr std::size_t max_entries =
      ((Kinds::max * (Kinds::max_ends * (Kinds::max_ends - 1) / 2)) + ... + 0);
  static constexpr bool on_coordinates = (Kinds::on_coordinates || ...);
  using State = TermForces<max_terms>;   // of the last stage
  using Output = TermForces<max_terms>;  // means over the step
  /// Parameters, constant during a run.
  struct Params {
    std::tuple<TermArray<typename Kinds::Param, Kinds::max>...> of_kinds;
    /// Returns the terms of kind number k of the list.
    template <std::size_t k>
    auto& of() noexcept {
      return std::get<k>(of_kinds);
    }
    /// Returns the number of all terms.
    std::size_t size() const noexcept {
      return std::apply([](const auto&... terms) noexcept { return (terms.size + ... + 0); }, of_kinds);
    }
  };
  using Stages = std::tuple<TermArray<typename Kinds::Stage, Kinds::max>...>;

  /// Calls f(kind, parameters, stages) for each kind.
  template <class F>
  static void each_kind(const Params& par, Stages& stages, F f) noexcept {
    with_kinds([&](auto... k) { (f(Kinds{}, std::get<k>(par.of_kinds), std::get<k>(stages)), ...); });
  }
  /// Calls f(kind, parameters) for each term.
  template <class F>
  static void each_param(const Params& par, F f) noexcept {
    const auto each_of = [&](auto kind, const auto& terms) noexcept {
      for (std::size_t t = 0; t < terms.size; ++t) f(kind, terms.list[t]);
    };
    with_kinds([&](auto... k) { (each_of(Kinds{}, std::get<k>(par.of_kinds)), ...); });
  }
  /// Calls f(kind, number among all terms, stage) for each term.
  template <class Stages, class F>
  static void each(Stages& stages, F f) noexcept {
    std::uint32_t number = 0;
    const auto each_of = [&](auto kind, auto& terms) noexcept {
      for (std::size_t t = 0; t < terms.size; ++t) f(kind, number++, terms.list[t]);
    };
    with_kinds([&](auto... k) { (each_of(Kinds{}, std::get<k>(stages)), ...); });
  }

 private:
  template <class F>
  static void with_kinds(F f) noexcept {
    [&]<std::size_t... k>(std::index_sequence<k...>) { f(std::integral_constant<std::size_t, k>{}...); }
    (std::index_sequence_for<Kinds...>{});
  }
};

}  // namespace godobject
