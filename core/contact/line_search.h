// Line search of a Newton iteration. With the friction of each contact at its solved value, an island's stage
// is the minimum of
//
//   (29)  E(V) = V^T A V / 2 - V^T b + h sum max(F_0 - eta_n v_n, 0)^2 / (2 eta_n)
//
// A and b without the normal forces: E is convex, and an iteration is a step of Newton's method. If it
// changes the modes of contacts (open, stick, slip), it is shortened to the minimum of E, so that iterations
// cannot cycle. Then V is scaled to the least E: there V^T dE/dV = 0, the energy balance with the exact law,
// for any assumed modes.
#pragma once

#include "core/contact/pass_on.h"
#include "core/contact/unbalanced.h"
#include "core/tuning.h"

namespace godobject {

/// Calls f(pack, V_c) for all contacts of an island, including those of nets if V has their nodes. V_c:
/// velocity of the contact's body, or relative to the other body of its pair.
template <class Velocities, class Contacts, std::size_t N, class F>
void each_pack(const Velocities& V, const Island& island, BodyContactScratch<Contacts, N>& w, F f) noexcept {
  w.graph.each_body(island, [&](std::uint32_t i, const TouchingBody& body) noexcept {
    for (std::uint32_t p = body.first_pack; p < body.end_pack; ++p) f(w.packs[p], V[i]);
  });
  w.graph.each_pair(island, [&](const TouchingPair& pair) noexcept {
    const SpatialVector V_rel = V[pair.child] - shifted(V[pair.parent], pair.d);
    for (std::uint32_t p = pair.first_pack; p < pair.end_pack; ++p) f(w.packs[p], V_rel);
  });
  if constexpr (requires { V[NetNodeNumber{}]; })
    if (island.has_net) each_net_pack(V, w.net, f);
}

template <class Contacts, std::size_t N, class F>
void each_pack(const Island& island, BodyContactScratch<Contacts, N>& w, F f) noexcept {
  each_pack(w.x.V, island, w, [&](ContactPack& c, const auto&) noexcept { f(c); });
}

/// First and second derivative of E along the search direction at step length t, using the exact law for
/// contacts that change mode.
struct LineSlope {
  Real slope = 0, curvature = 0;
};
template <std::size_t max_packs>
LineSlope slope_at(Real t, const LineSlope& line, Real h, const LinePacks<max_packs>& packs) noexcept {
  Pack slope{}, curvature{};  // zeros
  for (std::size_t i = 0; i < packs.size; ++i) {
    const LinePack& c = packs.list[i];
    const Pack F_n = c.F_n - c.by * t;
    slope += (c.active * F_n - max(F_n, Pack(0))) * c.v_n;
    curvature += (mode_of(F_n) - c.active) * c.by * c.v_n;
  }
  return {.slope = line.slope + t * line.curvature + h * total(slope),
          .curvature = line.curvature + h * total(curvature)};
}

/// Lists the contacts of an island that change their modes for step lengths in [0, t_max]. Normal velocities:
/// from(pack) + t by(pack).
template <class Contacts, std::size_t N, class From, class By>
void find_mode_changes(Real t_max, const Island& island, BodyContactScratch<Contacts, N>& w, From from,
                       By by) noexcept {
  w.line.size = 0;
  each_pack(island, w, [&](const ContactPack& c) noexcept {
    const Pack v_n = by(c), F_n = c.F_0 - c.eta_n * from(c), F_by = c.eta_n * v_n;
    if (differ(mode_of(F_n), c.active) || differ(mode_of(F_n - F_by * t_max), c.active))
      w.line.list[w.line.size++] = {.F_n = F_n, .by = F_by, .v_n = v_n, .active = c.active};
  });
}

/// Finds t in [0, t_max] with -tolerance <= dE/dt <= 0 by Newton's method from t = 1, safeguarded with
/// bisection. dE/dt is monotone because E is convex. t_max >= 1.
template <class Slope>
Real exact_line_search(Real t_max, Real tolerance, Slope slope_at) noexcept {
  Real lo = 0, hi = t_max, t = 1;
  for (int k = 0; k < max_line_steps; ++k) {
    const LineSlope at = slope_at(t);
    if (at.slope <= 0) {
      lo = t;
      if (at.slope >= -tolerance || t == t_max) break;
    } else {
      hi = t;
    }
    t -= (at.slope + line_aim * tolerance) / at.curvature;
    if (!(t > lo && t < hi)) t = lo + (hi - lo) / 2;
  }
  return lo;
}

/// True if a contact is not in the mode that was solved for.
inline bool has_changed_mode(const ContactPack& c) noexcept {
  return differ(mode_of(c.F_0 - c.eta_n * c.n.dot(c.v)), c.active);
}

/// Computes the velocities of the contact points at V, and stores their normal velocities at V_0 in v_n_0.
/// Returns true if a contact has changed its mode.
template <class Contacts, std::size_t N>
bool move_contacts(const Island& island, BodyContactScratch<Contacts, N>& w) noexcept {
  bool differs = false;
  each_pack(w.x.V, island, w, [&](ContactPack& c, const auto& V) noexcept {
    c.v_n_0 = c.n.dot(c.v);
    move(c, V);
    differs = differs || has_changed_mode(c);
  });
  return differs;
}

/// Moves V along the line from V_0 to V to the least E (29). A V_0 = AV_0 and A V = b - r hold, with the
/// modes that were solved for, before and after.
template <class System, class Contacts, std::size_t N>
void search_line(Real h, const Island& island, const System& system,
                 BodyContactScratch<Contacts, N>& w) noexcept {
  auto& x = w.x;
  const auto& b = system.b;
  SpatialSum slope, end;
  system.each([&](auto u) noexcept {
    const auto d = x.V[u] - x.V_0[u];
    slope.add(d, x.AV_0[u] - b[u]);
    end.add(d, x.r[u]);
  });
  find_mode_changes(
      1, island, w, [](const ContactPack& c) noexcept { return c.v_n_0; },
      [](const ContactPack& c) noexcept { return c.n.dot(c.v) - c.v_n_0; });
  const LineSlope line{.slope = slope, .curvature = -end - slope};
  const Real t = exact_line_search(1, line_tolerance * -slope,
                                   [&](Real at) noexcept { return slope_at(at, line, h, w.line); });
  if (t == 1) return;
  system.each([&](auto u) noexcept {
    x.V[u] = x.V_0[u] + (x.V[u] - x.V_0[u]) * t;
    x.r[u] = (b[u] - x.AV_0[u]) * (1 - t) + x.r[u] * t;
  });
  each_pack(x.V, island, w, [](ContactPack& c, const auto& V) noexcept { move(c, V); });
}

/// True if an island is free: no contact, joint or term with the world, and no device.
template <class Contacts, std::size_t N>
bool is_free_island(const Island& island, BodyContactScratch<Contacts, N>& w) noexcept {
  bool is = !island.has_terms;
  w.graph.each_body(island, [&](std::uint32_t i, const TouchingBody& body) noexcept {
    is = is && body.first_pack == body.end_pack && !w.stages[i].is_held;
    if constexpr (Contacts::jointed) is = is && !w.graph.joints.edges[i].on_world();
  });
  return is;
}

/// True if nets of the system may drift (core/net/drifting.h).
template <class System, class Contacts>
inline constexpr bool may_drift = false;
template <class System, class Contacts>
requires(System::is_coupled&& Contacts::has_net) inline constexpr bool may_drift<System, Contacts> =
    Contacts::Net::max_faces > 0;

/// Translation of an island as a whole, with its momentum. Zero if bodies touch the world, or nodes; but nets
/// that touch each other alone have one.
template <class System, class Contacts, std::size_t N>
struct IslandTranslation {
  static constexpr bool is_zero = !Contacts::between_bodies || System::is_coupled;
  const BodyContactScratch<Contacts, N>& w;
  Column v = Column(Pack(0));

  IslandTranslation(const Island& island, const System& system,
                    BodyContactScratch<Contacts, N>& scratch) noexcept
      : w(scratch) {
    if constexpr (!is_zero) {
      if (!is_free_island(island, scratch)) return;
      Real M = 0;
      system.each([&](std::uint32_t u) noexcept {
        v += system.b[u].v;
        M += w.stages[u].M;
      });
      v = v * (1 / M);
    }
    if constexpr (may_drift<System, Contacts>)
      set_drifts(scratch.net, scratch.net.faces.group,
                 [&](std::uint32_t n) noexcept { return system.b.nodes[n]; });
  }
  /// Returns the drift of a node.
  Column drift(NetNodeNumber u) const noexcept { return w.net.faces.drift[u.n]; }
  template <class U>
  bool drifts(U) const noexcept {
    if constexpr (may_drift<System, Contacts> && std::is_same_v<U, NetNodeNumber>)
      return w.net.faces.num_drifting > 0;
    return false;
  }
  /// Returns V relative to the translation. The overload below returns b without the translation's momentum.
  template <class U, class Vector>
  auto off(U u, const Vector& V) const noexcept {
    if constexpr (may_drift<System, Contacts> && std::is_same_v<U, NetNodeNumber>)
      return drifts(u) ? V[u] - drift(u) : V[u];
    else if constexpr (is_zero) return V[u];
    else return V[u] - SpatialVector{.w = Column(Pack(0)), .v = v};
  }
  template <class U, class Vector>
  auto without_momentum(U u, const Vector& b) const noexcept {
    if constexpr (may_drift<System, Contacts> && std::is_same_v<U, NetNodeNumber>)
      return drifts(u) ? b[u] - drift(u) * w.net.m[u.n] : b[u];
    else if constexpr (is_zero) return b[u];
    else return b[u] - SpatialVector{.w = Column(Pack(0)), .v = v * w.stages[u].M};
  }
  /// Returns the velocity with its relative part scaled by s.
  template <class U, class Vector>
  auto scaled(U u, const Vector& V, Real s) const noexcept {
    if constexpr (may_drift<System, Contacts> && std::is_same_v<U, NetNodeNumber>)
      return drifts(u) ? off(u, V) * s + drift(u) : V[u] * s;
    else if constexpr (is_zero) return V[u] * s;
    else return off(u, V) * s + SpatialVector{.w = Column(Pack(0)), .v = v};
  }
};

/// Scales V, relative to the translation c of the island, to the least E (29), so that free bodies keep their
/// momentum. Returns the largest unbalanced force times h; r: all of them.
///
///   V = c + s (V - c),   r = (b - M c) (1 - s) + s r,   c = sum b / sum M
template <class System, class Contacts, std::size_t N>
Real scale_velocities(Real h, const Island& island, const System& system,
                      BodyContactScratch<Contacts, N>& w) noexcept {
  auto& x = w.x;
  const auto& b = system.b;
  const IslandTranslation<System, Contacts, N> whole(island, system, w);
  SpatialSum VAV, Vb;
  system.each([&](auto u) noexcept {
    const auto V = whole.off(u, x.V), b_off = whole.without_momentum(u, b);
    VAV.add(V, b_off - x.r[u]);
    Vb.add(V, b_off);
  });
  find_mode_changes(
      max_scale, island, w, [](const ContactPack&) noexcept { return Pack(0); },
      [](const ContactPack& c) noexcept { return c.n.dot(c.v); });
  const LineSlope ray{.slope = -Vb, .curvature = VAV};
  const Real s = exact_line_search(max_scale, scale_tolerance * VAV,
                                   [&](Real at) noexcept { return slope_at(at, ray, h, w.line); });
  system.each([&](auto u) noexcept {
    x.V[u] = whole.scaled(u, x.V, s);
    x.r[u] = whole.without_momentum(u, b) * (1 - s) + x.r[u] * s;
  });
  each_pack(island, w, [&](ContactPack& c) noexcept { c.v *= Pack(s); });
  return largest_residual(system, w);
}

}  // namespace godobject
