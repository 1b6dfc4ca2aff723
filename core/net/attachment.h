// Attachments of nodes in a stage: sewn or glued to a body other than the carrier.
//
//   (49)  impulse J - kappa (v_n - v_b - w_b x r) on the node, its opposite on the body;  kappa = h (h k + g)
//
// Like an anchor (42). Taking the lever at the node makes rigid motion force-free and conserves angular
// momentum. In the system an attachment is a contact that always sticks: a = kappa, b = 0. Anchors, by
// contrast, do not appear between node and carrier (44), because node velocities are carrier-relative.
#pragma once

#include <algorithm>

#include "core/joint/tree.h"
#include "core/net/scratch.h"

namespace godobject {

/// Linearises the attachments at the predicted nodes and bodies. at: predicted places of the bodies.
template <class Net, std::size_t N, class Places>
void begin_attachments(const typename Net::Params& par, const Places& at, Real h,
                       NetStage<Net, N>& w) noexcept {
  if constexpr (Net::max_attachments > 0) {
    w.num_attachments = 0;
    for (const NetAttachment& of : par.attachments) {
      const bool on_world = of.body == world;
      const TreePlace place = on_world ? TreePlace{} : at[of.body];
      const Vec3 p_n = w.p[of.node].vec(), r = p_n - place.p_W, x = r - place.R_WB * of.p_B;
      const Vec3 x_dot = w.v[of.node].vec() - place.V.v - place.V.w.cross(p_n - place.a_W);
      const Real h_k = h * of.k;
      w.contacts[w.num_attachments++] = {
          .node = of.node,
          .body = on_world ? NetContactTerm::on_world : static_cast<std::uint32_t>(of.body),
          .carrier = par.nodes[of.node].body,
          .face = {},
          .n = Column(Pack(0)),
          .r = Column(r),
          .a = h * (h_k + of.g),
          .b = 0,
          .J = Column(Vec3((x_dot * h - x) * h_k))};
    }
  }
}

/// Makes the impulses of attachments relative to V_p of jointed bodies.
template <class Twists, class Net, std::size_t N>
void shift_attachments(const Twists& V_p, NetStage<Net, N>& w) noexcept {
  for (NetContactTerm& one : w.attached())
    if (one.body != NetContactTerm::on_world) one.J += shifted(V_p[one.body], one.r).v * one.a;
}

/// Calls f(body, impulse on it about its centre of mass) at the velocities V, of nodes relative to the world.
template <class Velocities, class Net, std::size_t N, class F>
void each_attachment_impulse(const Velocities& V, const NetStage<Net, N>& w, F f) noexcept {
  for (const NetContactTerm& one : w.attached()) {
    if (one.body == NetContactTerm::on_world) continue;
    const Column x_dot = V.nodes[one.node] - shifted(V.bodies[one.body], one.r).v;
    f(one.body, moved_wrench({.w = Column(Pack(0)), .v = x_dot * one.a - one.J}, one.r));
  }
}

/// True if the node is attached to the body.
template <std::size_t max>
bool is_attached(const NetAttachments<max>& all, std::uint32_t node, std::size_t body) noexcept {
  if constexpr (max == 0) return false;
  const NetAttachment* of =
      std::lower_bound(all.begin(), all.end(), node,
                       [](const NetAttachment& one, std::uint32_t n) noexcept { return one.node < n; });
  for (; of != all.end() && of->node == node; ++of)
    if (of->body == body) return true;
  return false;
}

}  // namespace godobject
