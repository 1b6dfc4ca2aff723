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

#include "core/solve/pass_on.h"
#include "core/solve/unbalanced.h"
#include "core/tuning.h"

namespace godobject {

/// Calls f(pack, V_c) for all contacts of an island, including those of nets if V has their nodes. V_c:
/// velocity of the contact's body, or relative to the other body of its pair.
template <class Velocities, class Contacts, std::size_t N, class F>
void each_pack(const Velocities& V, const Island& island, BodyContactScratch<Contacts, N>& w, F f) noexcept {
  w.graph.each_body(island, [&](std::uint32_t i, const TouchingContacts& body) noexcept {
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
    t -= (at.slope + Real(0.5) * tolerance) / at.curvature;
    if (!(t > lo && t < hi)) t = lo + (hi - lo) / 2;
  }
  return lo;
}

/// Computes the velocities of the contact points at V, and stores their normal velocities at V_0 in v_n_0.
/// Returns true if a contact has changed its mode.
template <class Contacts, std::size_t N>
bool move_contacts(const Island& island, BodyContactScratch<Contacts, N>& w) noexcept {
  bool differs = false;
  each_pack(w.x.V, island, w, [&](ContactPack& c, const auto& V) noexcept {
    c.v_n_0 = c.n.dot(c.v);
    move(c, V);
    differs = differs || differ(mode_of(c.F_0 - c.eta_n * c.n.dot(c.v)), c.active);
  });
  return differs;
}

/// Start of a line of an unknown: its velocity V, and r = b - A V with the modes that were solved for.
template <class Velocity>
struct LineStart {
  Velocity V, r;
};

/// Moves V, and its residual r, along the line from a start to V, to the least E (29) for step lengths t in
/// [0, t_max]. Returns t. tolerance: share of the slope at the start. start(u): LineStart of unknown u.
/// v_n_from(pack): normal velocities at the start; at t = 1 they are those of the contact points.
template <class System, class Contacts, std::size_t N, class Start, class NormalSpeeds>
Real search_line(Real t_max, Real tolerance, Real h, const Island& island, const System& system,
                 BodyContactScratch<Contacts, N>& w, Start start, NormalSpeeds v_n_from) noexcept {
  auto& x = w.x;
  SpatialSum fall, curvature;
  system.each([&](auto u) noexcept {
    const auto from = start(u);
    const auto d = x.V[u] - from.V;
    fall.add(d, from.r);
    curvature.add(d, from.r - x.r[u]);
  });
  w.line.size = 0;  // contacts that change their modes on the line
  each_pack(island, w, [&](const ContactPack& c) noexcept {
    const Pack from = v_n_from(c), v_n = c.n.dot(c.v) - from;
    const Pack F_n = c.F_0 - c.eta_n * from, F_by = c.eta_n * v_n;
    if (differ(mode_of(F_n), c.active) || differ(mode_of(F_n - F_by * t_max), c.active))
      w.line.list[w.line.size++] = {.F_n = F_n, .by = F_by, .v_n = v_n, .active = c.active};
  });
  const LineSlope line{.slope = -fall, .curvature = curvature};
  const Real t = exact_line_search(t_max, tolerance * line.curvature,
                                   [&](Real at) noexcept { return slope_at(at, line, h, w.line); });
  if (t == 1) return t;
  system.each([&](auto u) noexcept {
    const auto from = start(u);
    x.V[u] = from.V + (x.V[u] - from.V) * t;
    x.r[u] = from.r * (1 - t) + x.r[u] * t;
  });
  return t;
}

/// Moves V along the line from V_0 to V to the least E (29). A V_0 = AV_0.
template <class System, class Contacts, std::size_t N>
void search_from_previous(Real h, const Island& island, const System& system,
                          BodyContactScratch<Contacts, N>& w) noexcept {
  const auto& x = w.x;
  const auto start = [&](auto u) noexcept {
    return LineStart<std::decay_t<decltype(x.V[u])>>{x.V_0[u], system.b[u] - x.AV_0[u]};
  };
  const Real t = search_line(1, line_tolerance, h, island, system, w, start,
                             [](const ContactPack& c) noexcept { return c.v_n_0; });
  if (t != 1) each_pack(x.V, island, w, [](ContactPack& c, const auto& V) noexcept { move(c, V); });
}

/// True if an island is free: no contact, joint or term with the world, and no device.
template <class Contacts, std::size_t N>
bool is_free_island(const Island& island, BodyContactScratch<Contacts, N>& w) noexcept {
  bool is = !island.has_terms;
  w.graph.each_body(island, [&](std::uint32_t i, const TouchingContacts& body) noexcept {
    is = is && body.first_pack == body.end_pack && !w.stages[i].is_held();
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

/// Returns the velocity c = sum b / sum M of an island as a whole, with its momentum. Zero if it is not free.
template <class System, class Contacts, std::size_t N>
Column translation_of(const Island& island, const System& system,
                      BodyContactScratch<Contacts, N>& w) noexcept {
  Column b(Pack(0));
  Real M = 0;
  if (!is_free_island(island, w)) return b;
  system.each([&](std::uint32_t u) noexcept {
    b += system.b[u].v;
    M += w.stages[u].M;
  });
  return b * (1 / M);
}

/// Scales V, relative to the translation c of the island, to the least E (29), so that free bodies keep their
/// momentum; drifting nets theirs. Returns the largest unbalanced force times h.
template <class System, class Contacts, std::size_t N>
Real scale_velocities(Real h, const Island& island, const System& system,
                      BodyContactScratch<Contacts, N>& w) noexcept {
  constexpr bool may_be_free = Contacts::between_bodies && !System::is_coupled;
  Column whole(Pack(0));
  if constexpr (may_be_free) whole = translation_of(island, system, w);
  if constexpr (may_drift<System, Contacts>)
    set_drifts(w.net, w.net.faces.group, [&](std::uint32_t n) noexcept { return system.b.nodes[n]; });
  const auto start = [&](auto u) noexcept {
    using Velocity = std::decay_t<decltype(w.x.V[u])>;
    if constexpr (may_be_free) {
      const SpatialVector V{.w = Column(Pack(0)), .v = whole};
      return LineStart<Velocity>{V, system.b[u] - V * w.stages[u].M};
    } else {
      if constexpr (may_drift<System, Contacts>) {
        if constexpr (std::is_same_v<Velocity, Column>) {
          if (w.net.faces.num_drifting > 0) {
            const Column& drift = w.net.faces.drift[u.n];
            return LineStart<Velocity>{drift, system.b[u] - drift * w.net.m[u.n]};
          }
        }
      }
      return LineStart<Velocity>{{}, system.b[u]};
    }
  };
  const Real s = search_line(max_scale, scale_tolerance, h, island, system, w, start,
                             [](const ContactPack&) noexcept { return Pack(0); });
  each_pack(island, w, [&](ContactPack& c) noexcept { c.v *= Pack(s); });
  return largest_residual(system, w);
}

}  // namespace godobject
