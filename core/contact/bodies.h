// Contacts between bodies, and of bodies with the world, where many of them touch.
//
// A stage of all bodies with their contacts (24) is A V = b with A symmetric and positive definite: the bodies' own
// blocks, and an impedance for each pair that touches. It is solved by a sparse factor (31), (33), a tower in one go,
// however high and stiff. Where that has no room, by conjugate gradients from rest, preconditioned by the elimination of
// the tree of joints and stiffest pairs (27), (30). From rest, every iterate keeps
//
//   (28)  V^T A V = V^T b
//
// the balance of energy of the exact solution. The modes of the contacts (open, stick, slip) are found by Newton
// iterations over that (29), island by island. What they leave is the residual.
#pragma once

#include "core/contact/jointed_bodies.h"

namespace godobject {

/// With eight, 9 of 16000 cases of the stability sweep gain energy; with sixteen none. On joints with sixteen one of 8000,
/// with twice as many none: what the joints take back (18) presses stiff contacts together.
template <bool jointed>
inline constexpr int max_touching_newton_iterations = jointed ? 32 : 16;
/// The first ones seek friction.
inline constexpr int num_seeking_passes = 5;
constexpr Pass touching_pass(int pass) noexcept {
  return pass < num_seeking_passes ? Pass::by_secant : Pass::as_it_was;
}
/// Of a pass: few while friction is still sought.
constexpr int num_iterations(int pass) noexcept { return touching_pass(pass) == Pass::by_secant ? 3 : 8; }
/// The iterations end when no force misses its law by more than this part of the largest normal force. What lasts is
/// found in two iterations; where many bodies hit each other the next ones find more of it, and are content with less:
/// of the friction in the end with what there is, of normal forces with as much as the sweep of tests/contacts allows.
constexpr Real friction_tolerance(int pass) noexcept {
  return 3e-3 * static_cast<Real>(1 << std::max(pass - 1, 0));
}
constexpr Real normal_tolerance(int pass) noexcept { return std::min(friction_tolerance(pass), Real(12e-3)); }
/// Friction nearer to its law than this part of the largest normal force stays as it is in the next pass.
inline constexpr Real friction_left_alone = 1e-3;

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

/// A and b of the bodies and pairs of an island for the cases their contacts are in.
/// all: of every contact, not of those alone whose case has changed.
template <class Contacts, std::size_t N>
void load_contacts(Real h, bool all, const Island& island, BodyContactScratch<Contacts, N>& w) noexcept {
  const auto has_changed = [&](std::uint32_t first, std::uint32_t end) noexcept {
    bool changed = all;
    for (std::uint32_t p = first; p < end; ++p) changed = changed || w.packs[p].changed;
    return changed;
  };
  w.tree.each_body(island, [&](std::uint32_t i, TouchingBody& body) noexcept {
    const BodyStage& stage = w.stages[i];
    if (has_changed(body.first_pack, body.end_pack)) {
      gather(w.packs, body.first_pack, body.end_pack, h, body.on_world, body.F);
      body.A = sum(body.on_world, stage);
    }
    w.b[i].w = body.F.w + stage.b_w;
    w.b[i].v = body.F.v + stage.b_v;
  });
  w.tree.each_pair(island, [&](TouchingPair& pair) noexcept {
    if (has_changed(pair.first_pack, pair.end_pack))
      pair.touches = gather(w.packs, pair.first_pack, pair.end_pack, h, pair.A, pair.F);
    if (!pair.touches) return;
    w.b[pair.child] = w.b[pair.child] + pair.F;
    w.b[pair.parent] = w.b[pair.parent] - moved_wrench(pair.F, pair.d);
  });
}

/// What the iteration is preconditioned by: the tree of an island, (27), (30).
template <class Contacts, std::size_t N>
void eliminate_tree(const Island& island, BodyContactScratch<Contacts, N>& w) noexcept {
  w.tree.each_body(island, [&](std::uint32_t i, TouchingBody& body) noexcept {
    body.subtree_A = sum(body.on_world * stiffness_cap(body.on_world, w.stages[i].M), w.stages[i]);
  });
  w.tree.each_pair(island, [&](TouchingPair& pair) noexcept {
    pair.stiffness_cap = stiffness_cap(pair.A, w.stages[pair.child].M);
  });
  eliminate(island, w.tree);
}

/// Forces of the contacts of an island at the velocities of their points, and their cases in the next pass. True: the
/// forces obey the law.
template <class Contacts, std::size_t N>
bool settle_contacts(int pass, const Island& island, BodyContactScratch<Contacts, N>& w,
                     ContactResidual& most) noexcept {
  const Real F_small = friction_left_alone * most.F_n();
  most = {};
  const Pass next = touching_pass(pass + 1);
  bool changed = false;
  each_pack(island, w, [&](ContactPack& c) noexcept {
    settle<false>(c, next, F_small, most);
    changed = changed || c.changed;
  });
  const Real F_n = most.F_n();
  const bool normal = most.normal() <= normal_tolerance(pass) * F_n;
  if (next == Pass::as_it_was) return normal || !changed;
  return normal && most.friction() <= friction_tolerance(pass) * F_n;
}

/// The velocities of the bodies of an island; V_0: those they are predicted to have.
template <class Contacts, std::size_t N>
void solve_island(Real h, const Island& island, BodyContactScratch<Contacts, N>& w) noexcept {
  if constexpr (Contacts::jointed) shift_contacts(w.tree.joints.V_p, h, island, w);
  ContactResidual most;
  each_pack(w.V_0, island, w, [](ContactPack& c, const AnchorTwist& V) noexcept { foresee(c, V); });
  w.factored = false;
  Real left = 0;
  int newton_iterations = 0, iterations = 0;
  for (bool done = false; !done && newton_iterations < max_touching_newton_iterations<Contacts::jointed>;
       ++newton_iterations) {
    load_contacts(h, newton_iterations == 0, island, w);
    w.factored = factorize(island, w.factored, w.tree, w.factor);
    if (!w.factored) eliminate_tree(island, w);
    left = w.factored ? solve_factored(island, w)
                      : iterate(num_iterations(newton_iterations), island, w, iterations);
    if (move_contacts(island, w)) {
      if (newton_iterations > 0) {  // those predicted solve nothing that could be lost
        if (w.factored) multiply(island, w.tree, w.V_0, w.AV_0);
        search_line(h, island, w);
      }
      left = scale_velocities(h, island, w);
    }
    done = settle_contacts(newton_iterations, island, w, most) &&
           left <= normal_tolerance(newton_iterations) * h * most.F_n();
    w.tree.each_body(island, [&](std::uint32_t i, const TouchingBody&) noexcept { w.V_0[i] = w.V[i]; });
  }
  w.report.residual = std::max({w.report.residual, left / h, most.worst()});
  w.report.newton_iterations = std::max(w.report.newton_iterations, newton_iterations);
  w.report.iterations = std::max(w.report.iterations, iterations);
}

/// The velocities of all bodies that touch anything; V_0: those they are predicted to have.
template <class Contacts, std::size_t N>
void solve_contacts(const typename Contacts::Params& par, const typename Contacts::State& before,
                    std::size_t num_bodies, Real h, BodyContactScratch<Contacts, N>& w) noexcept {
  find_contacts(par, before, num_bodies, w.finder, w.near);
  find_pairs(par, num_bodies, h, w);
  begin_contacts(par, before, num_bodies, h, w);
  w.report = {.num_near = w.near.size};
  for (std::size_t n = 0; n < w.tree.num_islands; ++n) solve_island(h, w.tree.islands[n], w);
}

/// The contact forces of packs [first, end) on their body, about its centre of mass; what they say goes into the report.
template <class Contacts, std::size_t N>
AnchorTwist sum_forces(std::uint32_t first, std::uint32_t end, Real h,
                       BodyContactScratch<Contacts, N>& w) noexcept {
  Vector3<Pack> tau = Vector3<Pack>::Constant(Pack(0)), f = tau;
  Pack deepest = 0;
  for (std::uint32_t p = first; p < end; ++p) {
    const ContactPack& c = w.packs[p];
    f += c.F;
    tau += c.r.cross(c.F);
    deepest = max(deepest, c.d_0 - h * c.n.dot(c.v));
    for (std::uint32_t left = bits(Pack(0) < c.n.dot(c.F)); left != 0; left &= left - 1)
      ++w.report.num_contacts;
  }
  w.report.deepest = std::max(w.report.deepest, largest(deepest));
  return {.w = sum(tau[0], tau[1], tau[2]), .v = sum(f[0], f[1], f[2])};
}

/// What the contacts carry over, and what they say.
template <class Contacts, std::size_t N>
void end_contacts(const typename Contacts::Params& par, Real h, BodyContactScratch<Contacts, N>& w) noexcept {
  w.last = 1 - w.last;
  ContactMemories<Contacts::max_contacts>& next = w.memories[w.last];
  next.size = 0;
  for (Wrench& F : w.wrenches) F = {};
  const auto on = [&](std::uint32_t body, const AnchorTwist& F) noexcept {
    w.wrenches[body].tau += F.w.vec();
    w.wrenches[body].f += F.v.vec();
  };
  for (std::size_t g = 0; g < w.num_groups; ++g) {
    const NearGroup& group = w.groups[g];
    std::uint32_t child = w.near.list[group.first].a, first_pack = w.tree.bodies[child].first_pack;
    if (group.pair == NearGroup::no_pair) {
      on(child, sum_forces(first_pack, w.tree.bodies[child].end_pack, h, w));
    } else {
      const TouchingPair& pair = w.tree.pairs[group.pair];
      const AnchorTwist F = sum_forces(pair.first_pack, pair.end_pack, h, w);
      on(pair.child, F);
      on(pair.parent, moved_wrench(F, pair.d) * Real(-1));
      child = pair.child;
      first_pack = pair.first_pack;
    }
    for (std::uint32_t i = group.first, n = 0; i < group.end; ++i, ++n) {
      const NearContact& near = w.near.list[i];
      const ContactPack& pack = w.packs[first_pack + n / 4];
      const std::size_t j = n % 4;
      const Real side = child == near.a ? 1 : -1;
      const Vec3 F = side * lane(pack.F, j), v = side * lane(pack.v, j);
      const Real depth = pack.d_0[j] - h * near.n_W.dot(v);
      if (!(near.n_W.dot(F) > 0) && !(depth > 0)) continue;
      next.list[next.size++] = carried_over(law_of(par, near), near.key, w.begun[i], h, near.n_W, depth, F);
    }
  }
}

}  // namespace godobject
