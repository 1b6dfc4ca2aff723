// Nodes: particles of three coordinates beside the bodies of a scene. What acts on them are gravity, contacts and terms
// (core/term); in the block system each is an unknown like a body, numbered after all of these.
#pragma once

#include <array>

#include "core/math/types.h"

namespace godobject {

struct NodeParams {
  Real m = 0;  // kg, > 0
};

/// What the integrator keeps of a node that has not moved yet: zero, or nothing.
template <class Memory>
Memory no_memory() noexcept {
  if constexpr (std::is_same_v<Memory, Vec3>) return Vec3::Zero();
  else return {};
}

/// Memory: what the integrator keeps of a node, its acceleration or nothing.
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

/// The nodes part of a scene.
template <std::size_t max_>
struct NodeList {
  static constexpr std::size_t max = max_;
  struct Params {
    std::array<NodeParams, max> list;
    std::size_t size = 0;
  };
};

/// Where a node is, and how it moves.
struct NodeMotion {
  Vec3 p_W = Vec3::Zero(), v_W = Vec3::Zero();
};

/// The nodes of a scene in a step. Scratch: undefined between steps.
template <std::size_t max, class State>
struct NodeScratch {
  std::array<NodeMotion, max> bases;  // where the stage starts
  std::array<Vec3, max> velocities;   // what the stage solves for
  std::array<State, max> next;        // committed if finite
};

}  // namespace godobject
