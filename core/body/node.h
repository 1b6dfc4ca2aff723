// State of a node of a net: a particle with three coordinates.
#pragma once

#include <type_traits>

#include "core/math/types.h"

namespace godobject {

/// Returns the initial memory of the integrator for a node: zero or empty.
template <class Memory>
Memory no_memory() noexcept {
  if constexpr (std::is_same_v<Memory, Vec3>) return Vec3::Zero();
  else return {};
}

/// State of a node. Memory: acceleration kept by the integrator, or empty.
template <class Memory>
struct NodeStateOf {
  Vec3 p_W = Vec3::Zero();  // m
  Vec3 v_W = Vec3::Zero();  // m/s
  [[no_unique_address]] Memory memory = no_memory<Memory>();
};

template <class Memory>
Real sum(const NodeStateOf<Memory>& x) noexcept {
  const Real moves = x.p_W.sum() + x.v_W.sum();
  if constexpr (std::is_same_v<Memory, Vec3>) return moves + x.memory.sum();
  return moves;
}

/// Position and velocity of a node.
struct NodeMotion {
  Vec3 p_W = Vec3::Zero(), v_W = Vec3::Zero();
};

}  // namespace godobject
