// Modes of contacts of nodes (24), with the predicted effect of their forces on the nodes.
//
// Newton iterations by secants evaluate the friction of (24) at the previous slip speed. Near sticking this
// reduces the friction error by only 20 % per iteration. (50) predicts the slip from the node's compliance in
// the factor of the nodes instead:
//
//   (50)  slip change per newton  h / m,  m = d^T D d along d, D of (43) without the contact:
//         slip     s* = s + (F_t - mu F_n) h / m,                   at which friction obeys the law
//         at first F_n = F_n- + (F_0 - eta_n v_n - F_n-) / (1 + eta_n h / m),  F_n- of the stage before
//                  F_t = -mu F_n s/|s| where it slips,                        v_n, s where the stage starts
//
// and eta_t is evaluated at s*. Neighbours yield too, so the node moves farther than predicted, never less.
// The first iteration uses the force itself. A net sliding as a whole is decelerated by mu F_n at any speed,
// whereas an eta_t would err by its acceleration, h a / |s|. If this reverses a slip, the contact sticks in
// the next iteration, whose eta_t does no work on slips.
#pragma once

#include "core/net/incomplete_factor.h"

namespace godobject {

/// Returns the compliance (50) of each node along unit direction d, m/(s N), including the node's other
/// contacts. own: this pack's contribution to m, excluded.
template <class Net, std::size_t N>
Pack compliance(std::size_t pack, const Vector3<Pack>& d, const Pack& own, Real h,
                const NetStage<Net, N>& w) noexcept {
  Pack give = 0;
  for (std::size_t j = 0; j < 4 && 4 * pack + j < w.near.size; ++j) {
    const std::uint32_t n = w.near.list[4 * pack + j].a;
    const Column along(lane(d, j));
    const auto of_node = [&](std::uint32_t i, Real share) noexcept -> Real {
      const Real m = dot(along, w.D[i] * along), held = dot(along, w.of_contacts[i] * along) - share * own[j];
      return m > 0 ? share * h / (m + std::max(held, Real(0))) : 0;  // otherwise the direction is undefined
    };
    give.set(j, of_node(n, 1));
    if (const FaceTouch* on = w.touched_face(4 * pack + j))
      each_weight(*on, [&](std::uint32_t i, Real weight) noexcept {
        give.set(j, give[j] + of_node(i, weight * weight));
      });
  }
  return give;
}

/// Returns a function of the slip speeds of a pack (50) at which friction equals the law.
template <class Net, std::size_t N>
auto predicted_slip(std::size_t pack, Real h, const NetStage<Net, N>& w) noexcept {
  return [=, &w](const ContactPack& c, const Vector3<Pack>& s, const Pack& speed, const Pack& F_n) noexcept {
    const Pack give = compliance(pack, s * (1 / speed), c.eta_t * h, h, w);
    return above_zero(speed + give * (c.eta_t * speed + c.f_slip - slipping_friction<Pack>(c, F_n)));
  };
}

/// Returns the velocities of a pack's nodes at the start of the stage, minus the predicted ones.
template <class Net, std::size_t N>
Vector3<Pack> start_less_predicted(std::size_t pack, const NetStage<Net, N>& w) noexcept {
  Vector3<Pack> change = Vector3<Pack>::Constant(Pack(0));
  for (std::size_t j = 0; j < 4 && 4 * pack + j < w.near.size; ++j) {
    const std::uint32_t n = w.near.list[4 * pack + j].a;
    Column of_node = w.v_free[n] - w.by_gravity - w.v[n];
    if (const FaceTouch* on = w.touched_face(4 * pack + j))
      of_node -= at_face(*on, w.v_free) - w.by_gravity - at_face(*on, w.v);
    set_lane(change, j, of_node.vec());
  }
  return change;
}

/// Sets the friction of the first iteration by (50), after the nodes are factored. Nodes are assumed to keep
/// their speed, because friction and springs mostly balance gravity. A node predicted to stick sticks; a
/// slipping one gets its whole friction along the slip. Skipped if there is only one iteration, because none
/// would detect reversed slips. The active set stays as predicted: (29) finds it, and another prediction
/// drives pinched nets if iterations are few.
template <class Net, std::size_t N>
void predict_friction(Real h, NetStage<Net, N>& w) noexcept {
  for (std::size_t p = 0; p < w.num_packs; ++p) {
    ContactPack& c = w.packs[p];
    const Pack F_before = max(w.initial[p].contact.F_n, Pack(0));  // zero for a new contact
    const Vector3<Pack> v = w.begins_at_solution ? c.v : Vector3<Pack>(c.v + start_less_predicted(p, w));
    const Pack v_n = c.n.dot(v);
    const Pack stiffer = 1 + c.eta_n * compliance(p, c.n, c.active * c.eta_n * h, h, w);
    const Pack F_n = max(F_before + (c.F_0 - c.eta_n * v_n - F_before) / stiffer, Pack(0));
    const Vector3<Pack> s = (v - c.n * v_n + c.v_xi) * c.active;
    const Pack speed = speed_of(s);
    c.eta_t = c.active * friction<Pack>(c, speed, F_n);
    if (w.par->max_iterations == 1) continue;
    set_tangents(c, s, speed, F_n);
    c.eta_t = select(c.eta_t < c.max_eta_t, Pack(0), c.eta_t);
  }
}

}  // namespace godobject
