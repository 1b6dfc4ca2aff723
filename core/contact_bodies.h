// Contacts between bodies, and of bodies with the world, where many of them touch.
//
// A stage of all bodies with their contacts (24) is A V = b with A symmetric and positive definite: the bodies' own
// blocks, and an impedance for each pair that touches. It is solved by conjugate gradients from rest, preconditioned by
// the tree of the stiffest pairs (27): a tower takes one iteration, however high and stiff. From rest, every iterate keeps
//
//   (28)  V^T A V = V^T b
//
// the balance of energy of the exact solution: work left undone cannot drive. The cases of the contacts are found by
// passes over that. What they leave is the residual.
#pragma once

#include "core/contact_pairs.h"

namespace godobject {

inline constexpr int max_touching_passes = 8;
inline constexpr int num_held_passes = 3;
constexpr Pass touching_pass(int pass) noexcept {
  return pass + num_held_passes < max_touching_passes ? Pass::by_secant : Pass::as_it_was;
}
/// Of a pass: few while friction is still sought.
constexpr int num_iterations(int pass) noexcept { return touching_pass(pass) == Pass::by_secant ? 3 : 8; }
/// The passes end when no force misses its law by more than this part of the largest normal force.
inline constexpr Real touching_tolerance = 3e-3;
/// Its iterations, one at least, end when all bodies' velocities are known to this, m/s.
inline constexpr Real velocity_tolerance = 1e-3;

/// Impedance and impulse at rest of the packs [first, end). False: none bears a force.
template <std::size_t max_packs>
bool gather(const std::array<ContactPack, max_packs>& packs, std::size_t first, std::size_t end, Real h,
            TwistBlock& A, AnchorTwist& F) noexcept {
  ContactSums sums;
  bool touches = false;
  for (std::size_t i = first; i < end; ++i) {
    if (!any(packs[i].touching > 0)) continue;
    touches = true;
    add<false>(packs[i], h, sums);
  }
  A = total(sums);
  F = total_impulse(sums);
  return touches;
}

/// Contacts of a body with the world, and its stage.
inline TwistBlock sum(TwistBlock A, const BodyStage& stage) noexcept {
  A.ww += stage.A_ww;
  A.vv += Block::identity() * stage.M;
  return A;
}

/// A and b of the bodies and pairs for the cases their contacts are in. The skew part of A acts on V_0. all: of every
/// contact, not of those alone whose case has changed.
template <class Contacts, std::size_t N>
void load_contacts(Real h, bool all, BodyContactScratch<Contacts, N>& w) noexcept {
  const auto has_changed = [&](std::uint32_t first, std::uint32_t end) noexcept {
    bool changed = all;
    for (std::uint32_t p = first; p < end; ++p) changed = changed || w.packs[p].changed;
    return changed;
  };
  for (std::size_t k = 0; k < w.tree.num_touching; ++k) {
    const std::uint32_t i = w.tree.order[k];
    TouchingBody& body = w.tree.bodies[i];
    const BodyStage& stage = w.stages[i];
    if (has_changed(body.first_pack, body.end_pack)) {
      gather(w.packs, body.first_pack, body.end_pack, h, body.on_world, body.F);
      body.A = sum(body.on_world, stage);
    }
    body.hung = sum(body.on_world * tamed(body.on_world, stage.M), stage);
    w.b[i].w = body.F.w + stage.b_w - cross(stage.s, w.V_0[i].w);
    w.b[i].v = body.F.v + stage.b_v;
  }
  for (std::size_t k = 0; k < w.tree.num_pairs; ++k) {
    TouchingPair& pair = w.tree.pairs[k];
    if (has_changed(pair.first_pack, pair.end_pack))
      pair.touches = gather(w.packs, pair.first_pack, pair.end_pack, h, pair.A, pair.F);
    if (!pair.touches) continue;
    pair.tamed = tamed(pair.A, w.stages[pair.child].M);
    w.b[pair.child] = w.b[pair.child] + pair.F;
    w.b[pair.parent] = w.b[pair.parent] - moved_wrench(pair.F, pair.d);
  }
}

/// Sum over the touching bodies.
template <class Contacts, std::size_t N>
Real dot(const BodyContactScratch<Contacts, N>& w, const std::array<AnchorTwist, N>& a,
         const std::array<AnchorTwist, N>& b) noexcept {
  Real sum = 0;
  for (std::size_t k = 0; k < w.tree.num_touching; ++k) sum += dot(a[w.tree.order[k]], b[w.tree.order[k]]);
  return sum;
}

/// The velocity, m/s, of the centre of mass at which a body would have the kinetic energy that it has at V; squared.
inline Real speed_sq(const BodyStage& stage, const AnchorTwist& V) noexcept {
  return dot(V.v, V.v) + dot(V.w, stage.A_ww * V.w) / stage.M;
}

/// V = A^-1 b by conjugate gradients, from the best multiple of V_0 and with all directions conjugate to it: (28) holds
/// for every iterate as it does from rest; what rounding takes of it is given back in the end. Every step is the best
/// one along its direction. Returns the largest force that is left unbalanced, times h.
template <class Contacts, std::size_t N>
Real iterate(int iterations, BodyContactScratch<Contacts, N>& w) noexcept {
  const auto each = [&](auto f) noexcept {
    for (std::size_t k = 0; k < w.tree.num_touching; ++k) f(w.tree.order[k]);
  };
  constexpr Real tiny = std::numeric_limits<Real>::min();
  multiply(w.tree, w.V_0, w.AV_0);
  const Real V_0_A_V_0 = std::max(dot(w, w.V_0, w.AV_0), tiny);
  const Real scale = dot(w, w.V_0, w.b) / V_0_A_V_0;
  each([&](std::uint32_t i) noexcept {
    w.V[i] = w.V_0[i] * scale;
    w.r[i] = w.Ap[i] = w.b[i] - w.AV_0[i] * scale;
  });
  Real rz = 1;
  bool converged = false;
  for (int k = 0; k < iterations; ++k) {
    solve(w.tree, w.Ap, w.z);
    Real error_sq = 0;
    each([&](std::uint32_t i) noexcept { error_sq = std::max(error_sq, speed_sq(w.stages[i], w.z[i])); });
    converged = k > 0 && error_sq <= velocity_tolerance * velocity_tolerance;
    if (converged) break;
    const Real mu = dot(w, w.AV_0, w.z) / V_0_A_V_0;
    const Real last = rz;
    rz = dot(w, w.r, w.z);
    const Real beta = k == 0 ? 0 : rz / last;
    each([&](std::uint32_t i) noexcept {
      w.p[i] = (k == 0 ? w.z[i] : w.z[i] + w.p[i] * beta) - w.V_0[i] * mu;
    });
    multiply(w.tree, w.p, w.Ap);
    const Real alpha = dot(w, w.p, w.r) / std::max(dot(w, w.p, w.Ap), tiny);
    each([&](std::uint32_t i) noexcept {
      w.V[i] = w.V[i] + w.p[i] * alpha;
      w.r[i] = w.r[i] - w.Ap[i] * alpha;
      w.Ap[i] = w.r[i];
    });
    w.report.iterations += 1;
  }
  if (!converged) {  // r of the recurrence may have drifted
    multiply(w.tree, w.V, w.Ap);
    each([&](std::uint32_t i) noexcept { w.r[i] = w.b[i] - w.Ap[i]; });
  }
  // A V = b - r
  const Real V_b = dot(w, w.V, w.b), V_A_V = V_b - dot(w, w.V, w.r);
  const Real balance = V_A_V > tiny ? V_b / V_A_V : 1;
  Real most = 0;
  each([&](std::uint32_t i) noexcept {
    w.V[i] = w.V[i] * balance;
    const Column left = w.b[i].v * (1 - balance) + w.r[i].v * balance;
    most = std::max(most, dot(left, left));
  });
  return std::sqrt(most);
}

/// Forces and next cases of all contacts. left: force unbalanced by the solve, N. True: the forces obey the law.
template <class Contacts, std::size_t N>
bool update_contacts(Pass next, const std::array<AnchorTwist, N>& V, Real left,
                     BodyContactScratch<Contacts, N>& w) noexcept {
  ContactMiss most;
  for (std::size_t k = 0; k < w.tree.num_touching; ++k) {
    const std::uint32_t i = w.tree.order[k];
    const TouchingBody& body = w.tree.bodies[i];
    for (std::uint32_t p = body.first_pack; p < body.end_pack; ++p) update(w.packs[p], V[i], next, most);
  }
  for (std::size_t k = 0; k < w.tree.num_pairs; ++k) {
    const TouchingPair& pair = w.tree.pairs[k];
    const AnchorTwist V_rel = V[pair.child] - shifted(V[pair.parent], pair.d);
    for (std::uint32_t p = pair.first_pack; p < pair.end_pack; ++p) update(w.packs[p], V_rel, next, most);
  }
  const Real miss = largest(most.miss);
  w.report.residual = std::max(left, miss);
  return miss <= touching_tolerance * largest(most.F_n);
}

/// The velocities of all bodies that touch anything; V_0: those they are predicted to have.
template <class Contacts, std::size_t N>
void solve_contacts(const typename Contacts::Params& par, const typename Contacts::State& before,
                    std::size_t num_bodies, Real step, Real h, BodyContactScratch<Contacts, N>& w) noexcept {
  find_contacts(par, num_bodies, w.finder, w.near);
  find_pairs(par, num_bodies, h, w);
  begin_contacts(par, before, num_bodies, step, h, w);
  w.report = {.num_near = w.near.size};
  static_cast<void>(update_contacts(touching_pass(0), w.V_0, 0, w));
  for (int pass = 0; pass < max_touching_passes; ++pass) {
    load_contacts(h, pass == 0, w);
    eliminate(w.tree);
    const Real left = iterate(num_iterations(pass), w);
    ++w.report.passes;
    const bool done = update_contacts(touching_pass(pass + 1), w.V, left / h, w);
    for (std::size_t k = 0; k < w.tree.num_touching; ++k) w.V_0[w.tree.order[k]] = w.V[w.tree.order[k]];
    if (done) break;
  }
}

/// What the contacts carry over, and what they say.
template <class Contacts, std::size_t N>
void end_contacts(const typename Contacts::Params& par, Real h, BodyContactScratch<Contacts, N>& w) noexcept {
  w.last = 1 - w.last;
  ContactMemories<Contacts::max_contacts>& next = w.memories[w.last];
  next.size = 0;
  for (Wrench& F : w.wrenches) F = {};
  std::size_t pairs = 0;
  for (std::size_t i = 0; i < w.near.size; ++i) {
    const NearContact& near = w.near.list[i];
    const bool on_world = near.b >= N;
    if (!on_world && (i == 0 || pair_of(w.near.list[i - 1]) != pair_of(near))) ++pairs;
    const ContactPack& pack = w.packs[w.place[i] / 4];
    const std::size_t j = w.place[i] % 4;
    const Real side = on_world || w.tree.pairs[pairs - 1].child == near.a ? 1 : -1;
    const Vec3 v = side * lane(pack.v, j), F = side * lane(pack.F, j);
    const Real depth = pack.d_0[j] - h * near.n_W.dot(v);
    const bool touches = near.n_W.dot(F) > 0;
    if (!touches && !(depth > 0)) continue;
    const ContactLaw& law = par.law(par.spheres[near.sphere].material, touched_material(par, near));
    next.list[next.size++] = carried_over(law, w.begun[i], h, near.n_W, F);
    const Vec3 point = near.c_W - par.spheres[near.sphere].radius * near.n_W;
    const auto on = [&](std::uint32_t body, const Vec3& f) noexcept {
      w.wrenches[body].f += f;
      w.wrenches[body].tau += (point - w.finder.at[body].p_W).cross(f);
    };
    on(near.a, F);
    if (!on_world) on(near.b, -F);
    w.report.num_contacts += touches ? 1 : 0;
    w.report.deepest = std::max(depth, w.report.deepest);
  }
}

}  // namespace godobject
