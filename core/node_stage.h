// Stage operations of the nodes of nets for the integrators. Scenes without nets compile none of it.
#pragma once

#include "core/stage.h"

namespace godobject {

/// True if the integrator keeps accelerations of nodes.
template <class S>
inline constexpr bool keeps_accelerations = !std::is_empty_v<typename S::Integrator::NodeMemory>;

/// Calls f(state, base, velocity of the last stage, next state) for all nodes.
template <Scene S, class F>
void each_node(const Params<S>& par, const State<S>& x, Scratch<S>& w, F f) noexcept {
  if constexpr (uses<NetOf<S>>)
    for (std::size_t n = 0; n < num_net_nodes(par); ++n)
      f(x.net.nodes[n], w.net.bases[n], w.contacts.x.V.nodes[n].vec(), w.net.next[n]);
}

/// Sets the bases of the first stage: y_n + t K_0.
template <Scene S>
void start_nodes(const Params<S>& par, const State<S>& x, Real t, Scratch<S>& w) noexcept {
  each_node(par, x, w, [&](const NodeState<S>& y, NodeMotion& base, const Vec3&, NodeState<S>&) noexcept {
    base = {.p_W = y.p_W + t * y.v_W, .v_W = y.v_W};
    if constexpr (keeps_accelerations<S>) base.v_W += t * y.memory;
  });
}

/// Sets the bases of the second stage (13): y_n + bh (K_0 + K_1).
template <Scene S>
void extend_nodes(const Params<S>& par, const State<S>& x, Real bh, Real h_1, Scratch<S>& w) noexcept {
  each_node(par, x, w, [&](const NodeState<S>& y, NodeMotion& base, const Vec3& v_1, NodeState<S>&) noexcept {
    const Vec3 a_1 = (v_1 - base.v_W) * (1 / h_1);
    base = {.p_W = y.p_W + bh * (y.v_W + v_1), .v_W = y.v_W + bh * (y.memory + a_1)};
  });
}

/// Sets the bases of another Euler step to the end of the previous one, of length h_1, s.
template <Scene S>
void follow_nodes(const Params<S>& par, const State<S>& x, Real h_1, Scratch<S>& w) noexcept {
  each_node(par, x, w, [&](const NodeState<S>&, NodeMotion& base, const Vec3& v_1, NodeState<S>&) noexcept {
    base = {.p_W = base.p_W + h_1 * v_1, .v_W = v_1};
  });
}

/// Saves the bases of a stage before it is subdivided (39), in the storage of its end state.
template <Scene S>
void keep_node_starts(const Params<S>& par, const State<S>& x, Scratch<S>& w) noexcept {
  each_node(par, x, w, [](const NodeState<S>&, NodeMotion& base, const Vec3&, NodeState<S>& next) noexcept {
    next.p_W = base.p_W;
    next.v_W = base.v_W;
  });
}
template <Scene S>
void restore_node_starts(const Params<S>& par, const State<S>& x, Scratch<S>& w) noexcept {
  each_node(par, x, w, [](const NodeState<S>&, NodeMotion& base, const Vec3&, NodeState<S>& next) noexcept {
    base = {.p_W = next.p_W, .v_W = next.v_W};
  });
}

/// Stores the end state of the last stage, of length h, s.
template <Scene S>
void end_nodes(const Params<S>& par, const State<S>& x, Real h, Scratch<S>& w) noexcept {
  each_node(par, x, w,
            [&](const NodeState<S>&, NodeMotion& base, const Vec3& v, NodeState<S>& next) noexcept {
              next.v_W = v;
              next.p_W = base.p_W + h * v;
              if constexpr (keeps_accelerations<S>) next.memory = (v - base.v_W) * (1 / h);
            });
}

}  // namespace godobject
