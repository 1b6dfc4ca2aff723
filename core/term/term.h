// Terms: forces between bodies, nodes and the world, as effective masses and impulses in the block system
// (26).
//
//   using Terms = TermList<DampedSprings<4>>;
//
// Kinds of terms are a file each, such as damped_spring.h; this file has the list of the kinds of a scene.
// Members of a kind: max, the capacity for its terms; Param, the parameters of one term; Stage, the data of
// one term in a stage.
// ends(): bodies or nodes that it couples. begin(): linearises it about the predicted end of the stage.
// load(): adds it to the block system. each_impulse(): its impulses at the velocities of the end.
#pragma once

#include <tuple>

#include "core/composition.h"
#include "core/joint/edges.h"

namespace godobject {

/// Bodies or nodes that a term couples, by number (node_number); i may be the world.
struct TermEnds {
  static constexpr std::uint32_t on_world = ~std::uint32_t(0);
  std::uint32_t i = on_world, j = 0;

  bool is_between() const noexcept { return i != on_world; }
};

/// Term in the graph of coupled bodies and nodes. Undefined between steps.
struct TermEdge : TermEnds {
  std::uint32_t island = 0, entry = 0;  // entry: of the island's system, if it is between two
};

/// Terms of one kind, up to its capacity.
template <class T, std::size_t max>
struct TermArray {
  std::array<T, max> list;
  std::size_t size = 0;
};

/// Terms part of a scene.
template <class... Kinds>
struct TermList {
  static constexpr std::size_t max_terms = (Kinds::max + ... + 0);
  using State = Empty;
  /// Parameters, constant during a run.
  struct Params {
    std::tuple<TermArray<typename Kinds::Param, Kinds::max>...> of_kinds;
    /// Returns the terms of kind number k of the list.
    template <std::size_t k>
    auto& of() noexcept {
      return std::get<k>(of_kinds);
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
