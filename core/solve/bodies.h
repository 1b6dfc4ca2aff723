// Contacts of bodies with the world and among each other.
//
// A stage of all bodies with their contacts (24) is A V = b with A symmetric and positive definite
// (core/system). A contains the bodies' own blocks, and an effective mass for each pair in contact. It is
// solved by its factor (31), (33), exactly for a tower of any height and stiffness. If blocks are short,
// conjugate gradients (27), (28) solve it. Newton iterations find the modes of the contacts (open, stick,
// slip), island by island (29). Their remaining error is reported as the residual.
#pragma once

#include "core/solve/begin.h"
#include "core/solve/jointed_bodies.h"
#include "core/solve/multipliers.h"
#include "core/tuning.h"

namespace godobject {

template <class Contacts>
using FrictionSearchOf =
    std::conditional_t<Contacts::between_bodies, FrictionAmongBodies, FrictionAgainstTheWorld>;

template <class FrictionSearch>
constexpr Pass pass_of(int iteration) noexcept {
  if (iteration < FrictionSearch::by_tangent) return Pass::by_tangent;
  return iteration < FrictionSearch::by_tangent + FrictionSearch::by_secant ? Pass::by_secant
                                                                            : Pass::unchanged;
}

/// Sums effective masses and impulses of an island's contacts in their current modes. all: include contacts
/// whose mode has not changed. Returns true if an active pair is not coupled in the system.
template <class Contacts, std::size_t N>
bool gather_contacts(Real h, bool all, const Island& island, BodyContactScratch<Contacts, N>& w) noexcept {
  constexpr bool tangents = FrictionSearchOf<Contacts>::tangents;
  const auto gather = [&](TouchingContacts& of) noexcept {
    bool changed = all || tangents;
    for (std::uint32_t p = of.first_pack; p < of.end_pack; ++p) changed = changed || w.packs[p].changed;
    if (!changed) return;
    ContactSums sums;
    of.touches = false;
    for (std::uint32_t p = of.first_pack; p < of.end_pack; ++p) {
      if (!any(w.packs[p].active > 0)) continue;
      of.touches = true;
      add<tangents>(w.packs[p], h, sums);
    }
    of.A = total(sums);
    of.F = total_impulse(sums);
  };
  bool is_new = all;
  w.graph.each_body(island, [&](std::uint32_t, TouchingContacts& of) noexcept { gather(of); });
  w.graph.each_pair(island, [&](TouchingPair& pair) noexcept {
    gather(pair);
    is_new = is_new || (pair.touches && pair.entry == no_slot);
  });
  return is_new;
}

/// Builds the sparsity pattern of an island: its unknowns and the pairs they couple.
template <class Contacts, std::size_t N>
void begin_system(const Island& island, BodyContactScratch<Contacts, N>& w) noexcept {
  w.system.clear();
  w.graph.each_body(island,
                    [&](std::uint32_t i, const TouchingContacts&) noexcept { w.system.add_unknown(i); });
  if constexpr (Contacts::jointed) add_bodies_to_parents(island, w);
  w.graph.each_pair(island, [&](TouchingPair& pair) noexcept {
    pair.entry = pair.touches || pair.is_deep ? w.system.couple(pair.parent, pair.child) : no_slot;
  });
  couple_terms(island, w);
  if constexpr (Contacts::has_net) {
    if (island.has_net)
      for (std::size_t k = 0; k < w.net.num_pairs; ++k)
        w.net.pairs[k].entry = w.system.couple(w.net.pairs[k].carrier, w.net.pairs[k].touched);
  }
  order(w.system);
}

/// Loads the linear system of an island: body stages (10), (11), (34), contacts (24) and joint stops (19).
/// first: true in the first Newton iteration.
template <class Contacts, std::size_t N>
void load_system([[maybe_unused]] Real h, [[maybe_unused]] bool first, const Island& island,
                 BodyContactScratch<Contacts, N>& w) noexcept {
  auto& system = w.system;
  system.begin_loading();
  w.graph.each_body(island, [&](std::uint32_t i, const TouchingContacts& body) noexcept {
    const BodyStage& stage = w.stages[i];
    system.set(i,
               {.ww = stage.A_ww + body.A.ww, .wv = body.A.wv, .vv = Block::identity() * stage.M + body.A.vv},
               stage.b + body.F);
  });
  w.graph.each_pair(island, [&](const TouchingPair& pair) noexcept {
    if (!pair.touches) return;
    system.add_between(pair.entry, pair.A, pair.d);
    system.add_impulse(pair.child, pair.F);
    system.add_impulse(pair.parent, moved_wrench(pair.F, pair.d) * Real(-1));
  });
  load_terms(island, w);
  if constexpr (Contacts::jointed) add_stops(island, w);
  if constexpr (Contacts::has_net) {
    w.system.keep();
    if (island.has_net) load_nodes(h, first, w);
  }
}

/// Evaluates the contact forces of an island at the velocities of its contact points and updates the modes
/// for the next iteration. Returns true if the forces obey the law.
template <class FrictionSearch, class Contacts, std::size_t N>
bool update_contact_modes(int iteration, [[maybe_unused]] Real h, const Island& island,
                          BodyContactScratch<Contacts, N>& w, ContactResidual& most) noexcept {
  const Real F_small = FrictionSearch::min_friction_change * most.F_n();
  most = {};
  const Pass next = pass_of<FrictionSearch>(iteration + 1);
  bool changed = false;
  // true if friction predicted along a slip (50) does positive work on it
  [[maybe_unused]] bool turned = false;
  each_pack(w.x.V, island, w, [&]<class V>(ContactPack& c, [[maybe_unused]] const V& v) noexcept {
    if constexpr (std::is_same_v<V, PackVelocity>) {
      turned = turned || is_slip_reversed(c);
      update_modes<true>(c, next, F_small, most, predicted_slip(v.number, h, w.net));
    } else update_modes<FrictionSearch::tangents>(c, next, F_small, most);
    changed = changed || c.changed;
  });
  const Real F_n = most.F_n();
  const bool normal = !turned && most.normal() <= FrictionSearch::normal_tolerance(iteration) * F_n;
  if (next == Pass::unchanged) return normal || !changed;
  return normal && most.friction() <= FrictionSearch::friction_tolerance(iteration) * F_n;
}

/// Solves A V = b with the complete factor and sets the residual r to zero.
template <class Contacts, std::size_t N>
void solve_complete(BodyContactScratch<Contacts, N>& w) noexcept {
  w.system.each([&](std::uint32_t u) noexcept {
    w.x.Ap[u] = w.system.b[u];
    w.x.r[u] = SpatialVector::zero();
  });
  factorize_and_solve(w.system, w.x.Ap, w.x.V);
}

/// Termination criteria of the iterations of a coupled system.
struct SolverLimits {
  bool has_contacts = false;
  int iteration_limit = 0;              // conjugate gradient iterations, summed over Newton iterations
  Real tolerance = velocity_tolerance;  // m/s, of all velocities

  /// Returns the limit of conjugate gradient iterations in the next Newton iteration. With contacts it is a
  /// share of the remaining ones, because contacts may change their modes afterwards.
  int next_limit(int iterations) const noexcept {
    const int left = iteration_limit - iterations;
    return has_contacts ? (left + net_iteration_divisor - 1) / net_iteration_divisor : left;
  }
};

/// Stores the residual impulses on the bodies of an island that neither contacts nor joints carry.
template <class Contacts, std::size_t N>
void store_unbalanced(const Island& island, BodyContactScratch<Contacts, N>& w) noexcept {
  w.is_unbalanced = true;
  w.graph.each_body(island, [&](std::uint32_t i, const TouchingContacts&) noexcept {
    if constexpr (Contacts::jointed)
      if (w.graph.joints.joined[i]) return;
    w.unbalanced[i] = w.x.r[i] * Real(-1);
  });
}

/// Solves for the velocities of the bodies of an island. V_0: predicted velocities.
template <class System, class Contacts, std::size_t N>
GODOBJECT_FLATTEN void solve_island(Real h, const Island& island, const SolverLimits& how, System& system,
                                    BodyContactScratch<Contacts, N>& w) noexcept {
  auto& x = w.x;
  using FrictionSearch = std::conditional_t<System::is_coupled, FrictionOnNets, FrictionSearchOf<Contacts>>;
  ContactResidual most;
  each_pack(x.V_0, island, w,
            [](ContactPack& c, const auto& V) noexcept { predict<FrictionSearch::tangents>(c, V); });
  constexpr int iteration_limit = (Contacts::jointed ? 2 : 1) * max_newton_iterations;
  Real left = 0;
  int newton_iterations = 0, iterations = 0;
  bool done = false;
  for (; !done && newton_iterations < iteration_limit; ++newton_iterations) {
    if (gather_contacts(h, newton_iterations == 0, island, w)) begin_system(island, w);
    load_system(h, newton_iterations == 0, island, w);
    bool converged = true;
    if (!System::is_coupled && w.system.is_complete) {
      if (newton_iterations > 0) w.system.multiply(x.V_0, x.AV_0);
      solve_complete(w);
      if constexpr (Contacts::max_terms > 0)
        if (island.has_terms) converge_multipliers(island, w);
      left = 0;
    } else {
      const bool searches = pass_of<FrictionSearch>(newton_iterations) != Pass::unchanged;
      const int next_limit = System::is_coupled ? how.next_limit(iterations)
                             : searches         ? max_cg_iterations_searching
                                                : max_cg_iterations;
      factorize(w.system);
      const Iterated taken =
          iterate(next_limit, how.tolerance, system, x,
                  [&](auto u, const auto& V) noexcept { return speed_sq_of(w.stages, u, V); });
      converged = taken.converged;
      iterations += taken.iterations;
      if constexpr (System::is_coupled) {
        compute_residual(system, x);
        w.net.is_balanced = true;
      }
      left = largest_residual(system, w);
    }
    if (move_contacts(island, w)) {
      // no search from V_0 in the first iteration: V_0 is only predicted and solves no system
      if (newton_iterations > 0) search_from_previous(h, island, system, w);
      left = scale_velocities(h, island, system, w);
      if constexpr (System::is_coupled) w.net.is_balanced = false;
    }
    done = update_contact_modes<FrictionSearch>(newton_iterations, h, island, w, most);
    if constexpr (System::is_coupled) {
      w.net.is_solved = done && converged;
      done = w.net.is_solved || iterations >= how.iteration_limit;
    } else {
      done = done && left <= FrictionSearch::normal_tolerance(newton_iterations) * h * most.F_n();
    }
    system.each([&](auto u) noexcept { x.V_0[u] = x.V[u]; });
  }
  if constexpr (Contacts::between_bodies && !System::is_coupled)
    if (left > 0) store_unbalanced(island, w);
  const Real residual = std::max(left / h, most.worst());
  if constexpr (System::is_coupled) {
    w.net.report = {.iterations = iterations,
                    .newton_iterations = newton_iterations,
                    .residual = residual,
                    .is_stopped = !w.net.is_solved};
    return;
  }
  w.report.num_without_room += w.system.is_complete ? 0 : 1;
  w.report.residual = std::max(w.report.residual, residual);
  if (most.F_n() > 0) w.report.residual_share = std::max(w.report.residual_share, residual / most.F_n());
  w.report.num_stopped += done ? 0 : 1;
  w.report.newton_iterations = std::max(w.report.newton_iterations, newton_iterations);
  w.report.iterations = std::max(w.report.iterations, iterations);
}

/// Solves for the velocities of all bodies in contact. V_0: predicted velocities. net: NetInput or None.
template <class Contacts, std::size_t N, class... Net>
void solve_contacts(const typename Contacts::Params& par, std::size_t num_bodies, Real h,
                    BodyContactScratch<Contacts, N>& w, const Net&... net) noexcept {
  w.finder.swept = w.stage.swept;
  find_contacts(par, w.memories.before(), num_bodies, h, w.finder, w.near);
  (find_net_contacts(par, net, num_bodies, w), ...);
  find_pairs(num_bodies, w);
  const ContactReport stages_before = w.stage.continues_step ? w.report : ContactReport{};
  w.report = {.num_near = w.near.size, .found = w.stage.found};
  if constexpr (Contacts::between_bodies) {
    w.is_unbalanced = false;
    w.unbalanced.fill(SpatialVector::zero());
  }
  begin_contacts(par, num_bodies, h, w);
  (begin_net_contacts(par, net, h, w), ...);
  for (std::size_t n = 0; n < w.graph.num_islands; ++n) {
    const Island& island = w.graph.islands[n];
    if constexpr (Contacts::jointed) shift_contacts(w.graph.joints.V_p, h, island, w);
    if (!island.has_net) solve_island(h, island, {}, w.system, w);
  }
  w.report.cover(stages_before);
  (solve_net(h, net, w), ...);
}

/// Returns the sum of contact forces on their body, about its centre of mass, and adds them to the report.
template <class Contacts, std::size_t N>
SpatialVector sum_forces(const TouchingContacts& of, Real h, BodyContactScratch<Contacts, N>& w) noexcept {
  Vector3<Pack> tau = Vector3<Pack>::Constant(Pack(0)), f = tau;
  Pack deepest = 0;
  for (std::uint32_t p = of.first_pack; p < of.end_pack; ++p) {
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

/// Adds the residual impulses on bodies, beyond the contact laws (22), (23), to the reported wrenches and
/// forces, which then equal the change of momentum.
template <class Contacts, std::size_t N>
[[gnu::noinline]] void report_unbalanced(Real h, BodyContactScratch<Contacts, N>& w) noexcept {
  Missing<Contacts, N> missing;
  for (std::size_t i = 0; i < N; ++i) {
    const SpatialVector F = w.unbalanced[i] * (1 / h);
    w.wrenches[i].tau += F.w.vec();
    missing.F_W[i] = F.v.vec();
  }
  pass_on(missing, w);
}

/// Stores the contact memory and completes the report.
template <class Contacts, std::size_t N>
void end_contacts(Real h, BodyContactScratch<Contacts, N>& w) noexcept {
  ContactMemories<Contacts::max_contacts>& next = w.memories.after();
  next.size = w.forces.size = 0;
  for (Wrench& F : w.wrenches) F = {};
  const auto on = [&](std::uint32_t body, const SpatialVector& F) noexcept {
    w.wrenches[body].tau += F.w.vec();
    w.wrenches[body].f += F.v.vec();
  };
  for (std::size_t g = 0; g < w.num_groups; ++g) {
    const NearGroup& group = w.groups[g];
    const std::uint32_t a = w.near.list[group.first].a;
    const TouchingContacts& of = contacts_of(group, w);
    const SpatialVector F = sum_forces(of, h, w);
    on(a, F);
    if constexpr (Contacts::between_bodies) {
      if (group.pair != NearGroup::no_pair) {
        const TouchingPair& pair = w.graph.pairs[group.pair];
        on(pair.parent, moved_wrench(F, pair.d) * Real(-1));
      }
    }
    std::uint32_t pack = of.first_pack;
    GroupPlaces<Contacts, N> places(a, w.near.list[group.first].b, w.finder);
    for (std::uint32_t i = group.first; i < group.end; i += 4, ++pack) {
      const NearFour near(&w.near.list[i], group.end - i);
      const Pack sides = near.sides(a);
      carry_over(near, sides, places.of(sides), near.all(&NearContact::p_W), w.stage, h, w.initial[pack],
                 w.packs[pack], next);
      add_bearing(near, sides, w.packs[pack], w.forces);
    }
  }
  if constexpr (Contacts::between_bodies)
    if (w.is_unbalanced) [[unlikely]]
      report_unbalanced(h, w);
}

}  // namespace godobject
