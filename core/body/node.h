// Nodes: particles with three coordinates beside the bodies of a scene. Gravity, contacts and terms
// (core/term) act on them. In the block system each node is an unknown like a body, numbered after all
// bodies.
#pragma once

#include <array>

#include "core/math/types.h"

namespace godobject {

struct NodeParams {
  Real m = 0;  // kg, > 0
};

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

/// Nodes part of a scene.
template <std::size_t max_>
struct NodeList {
  static constexpr std::size_t max = max_;
  struct Params {
    std::array<NodeParams, max> list;
    std::size_t size = 0;
  };
};

/// Position and velocity of a node.
struct NodeMotion {
  Vec3 p_W = Vec3::Zero(), v_W = Vec3::Zero();
};

/// Working storage for the nodes of a scene in a step, undefined between steps.
template <std::size_t max, class State>
struct NodeScratch {
  std::array<NodeMotion, max> bases;  // start of the stage
  std::array<Vec3, max> velocities;   // solution of the stage
  std::array<State, max> next;        // committed if finite
};

}  // namespace godobject
