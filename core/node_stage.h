// The nodes of a scene in a stage, and from stage to stage as an integrator asks for it. A scene without nodes has none of
// this.
#pragma once

#include "core/stage.h"

namespace godobject {

/// What the integrator keeps of nodes is their acceleration.
template <class S>
inline constexpr bool keeps_accelerations = !std::is_empty_v<typename S::Integrator::NodeMemory>;

/// The bases of the first stage: y_n + t K_0.
template <Scene S>
void start_nodes(const Params<S>& par, const State<S>& x, Real t, Scratch<S>& w) noexcept {
  if constexpr (uses<NodesOf<S>>) {
    for (std::size_t j = 0; j < num_nodes(par); ++j) {
      const NodeState<S>& y = x.nodes[j];
      w.nodes.bases[j] = {.p_W = y.p_W + t * y.v_W, .v_W = y.v_W};
      if constexpr (keeps_accelerations<S>) w.nodes.bases[j].v_W += t * y.memory;
    }
  }
}

/// (13)  Those of the second: y_n + bh (K_0 + K_1).
template <Scene S>
void extend_nodes(const Params<S>& par, const State<S>& x, Real bh, Real h_1, Scratch<S>& w) noexcept {
  if constexpr (uses<NodesOf<S>>) {
    for (std::size_t j = 0; j < num_nodes(par); ++j) {
      const NodeState<S>& y = x.nodes[j];
      const Vec3& v_1 = w.nodes.velocities[j];
      const Vec3 a_1 = (v_1 - w.nodes.bases[j].v_W) * (1 / h_1);
      w.nodes.bases[j] = {.p_W = y.p_W + bh * (y.v_W + v_1), .v_W = y.v_W + bh * (y.memory + a_1)};
    }
  }
}

/// Those of a second Euler step: where the first one ended.
template <Scene S>
void follow_nodes(const Params<S>& par, Real h_1, Scratch<S>& w) noexcept {
  if constexpr (uses<NodesOf<S>>) {
    for (std::size_t j = 0; j < num_nodes(par); ++j) {
      const Vec3& v_1 = w.nodes.velocities[j];
      w.nodes.bases[j] = {.p_W = w.nodes.bases[j].p_W + h_1 * v_1, .v_W = v_1};
    }
  }
}

/// The end of the last stage, of length h.
template <Scene S>
void end_nodes(const Params<S>& par, Real h, Scratch<S>& w) noexcept {
  if constexpr (uses<NodesOf<S>>) {
    for (std::size_t j = 0; j < num_nodes(par); ++j) {
      const NodeMotion& base = w.nodes.bases[j];
      NodeState<S>& next = w.nodes.next[j];
      next.v_W = w.nodes.velocities[j];
      next.p_W = base.p_W + h * next.v_W;
      if constexpr (keeps_accelerations<S>) next.memory = (next.v_W - base.v_W) * (1 / h);
    }
  }
}

}  // namespace godobject
