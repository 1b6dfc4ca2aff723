// In which modes contacts of nodes are taken (24): what their forces do to the nodes is foreseen.
//
// Newton iterations by secants take the friction of (24) at the speed that it leaves, and where a contact is about to stick that is
// less and less each time: of what friction misses, four fifths are left by each. But a node gives way to a force as the
// factor of the nodes says,
//
//   (50)  by h / m a newton,  m = d^T D d along d, D of (43) without the contact:
//         slip     s* = s + (F_t - mu F_n) h / m,                            where friction is as the law says
//         at first F_n = F_n- + (F_0 - eta_n v_n - F_n-) / (1 + eta_n h / m),  F_n- of the stage before
//                  F_t = -mu F_n s/|s| where it slips,                        v_n, s where the stage starts
//
// and eta_t is taken at s*. Neighbours give way, too, so that the node goes farther than that, never less. In
// the first iteration the force itself is given: a net that slides as a whole is slowed down by mu F_n at any
// speed, where an eta_t would be off by its acceleration, h a / |s|. A slip that this turns round sticks in
// the next iteration, whose eta_t does no work on slips.
#pragma once

#include "core/net/incomplete_factor.h"

namespace godobject {

/// (50)  How the nodes of a pack give way, each along its own d of length 1, m/s per N. own: what their contacts in the pack have
/// of m, which others of the same node hold as well.
template <class Net, std::size_t N>
Pack compliance(std::size_t pack, const Vector3<Pack>& d, const Pack& own, Real h,
                const NetStage<Net, N>& w) noexcept {
  Pack give = 0;
  for (std::size_t j = 0; j < 4 && 4 * pack + j < w.near.size; ++j) {
    const std::uint32_t n = w.near.list[4 * pack + j].a;
    const Column along(lane(d, j));
    const Real m = dot(along, w.D[n] * along), held = dot(along, w.of_contacts[n] * along) - own[j];
    if (m > 0) give.set(j, h / (m + std::max(held, Real(0))));  // otherwise there is no direction
  }
  return give;
}

/// (50)  The speeds of a pack where friction is as the law says.
template <class Net, std::size_t N>
auto predicted_slip(std::size_t pack, Real h, const NetStage<Net, N>& w) noexcept {
  return [=, &w](const ContactPack& c, const Vector3<Pack>& s, const Pack& speed, const Pack& F_n) noexcept {
    const Pack give = compliance(pack, s * (1 / speed), c.eta_t * h, h, w);
    return above_zero(speed + give * (c.eta_t * speed + c.f_slip - c.mu * F_n));
  };
}

/// Velocities of the nodes of a pack where the stage starts, less those that they are predicted to have.
template <class Net, std::size_t N>
Vector3<Pack> start_less_predicted(std::size_t pack, const NetStage<Net, N>& w) noexcept {
  Vector3<Pack> change = Vector3<Pack>::Constant(Pack(0));
  for (std::size_t j = 0; j < 4 && 4 * pack + j < w.near.size; ++j) {
    const std::uint32_t n = w.near.list[4 * pack + j].a;
    set_lane(change, j, (w.v_free[n] - w.by_gravity - w.v[n]).vec());
  }
  return change;
}

/// Sets the friction of the first iteration, once the nodes are factored, by (50). Nodes go on as fast as
/// they are, since friction and springs mostly bear what gravity adds. A node that sticks there is taken to
/// stick; one that slips gets its whole friction along that slip. Not where one iteration is all: no other
/// finds slips which turn round. Which contacts touch stays as it was foreseen: (29) finds it, and another
/// guess drives nets that are
/// pinched where iterations are few.
template <class Net, std::size_t N>
void predict_friction(Real h, NetStage<Net, N>& w) noexcept {
  for (std::size_t p = 0; p < w.num_packs; ++p) {
    ContactPack& c = w.packs[p];
    const Pack F_before = max(w.initial[p].F_n, Pack(0));  // of a new one, none
    const Vector3<Pack> v = w.begins_at_solution ? c.v : Vector3<Pack>(c.v + start_less_predicted(p, w));
    const Pack v_n = c.n.dot(v);
    const Pack stiffer = 1 + c.eta_n * compliance(p, c.n, c.touching * c.eta_n * h, h, w);
    const Pack F_n = max(F_before + (c.F_0 - c.eta_n * v_n - F_before) / stiffer, Pack(0));
    const Vector3<Pack> s = (v - c.n * v_n + c.v_xi) * c.touching;
    const Pack speed = speed_of(s);
    c.eta_t = c.touching * friction(c, speed, F_n);
    if (w.par->max_iterations == 1) continue;
    set_tangents(c, s, speed, F_n);
    c.eta_t = select(c.eta_t < c.max_eta_t, Pack(0), c.eta_t);
  }
}

}  // namespace godobject
