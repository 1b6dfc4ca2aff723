// Jointed bodies in contact with other bodies: their joints in a stage, and the joint wrenches.
//
// Joints require L V = L beta (18). V_p satisfies it with roots at rest and no motion along the axes. The
// stage is solved (30) for W = V - V_p: it obeys L W = 0, and (33) holds for it unchanged. The bodies'
// equations then have the right side b - A V_p, and the contact points have the initial velocities of V_p.
#pragma once

#include "core/composition.h"
#include "core/joint/tree.h"
#include "core/solve/island_terms.h"
#include "core/solve/line_search.h"
#include "core/solve/momentum.h"
#include "core/tuning.h"

namespace godobject {

/// Contact part of a scene with jointed bodies.
template <class Contacts>
struct OnJoints : Contacts {
  static constexpr bool jointed = true;
};

/// Joints of bodies in contact, in a stage. Undefined between steps.
template <std::size_t N, class Joints>
struct TouchingJoints : JointsInStage<N, Joints> {
  struct Node {
    Wrench F_C;
  };
  std::array<Node, N> nodes;
};

/// Returns the place with its anchor at a_W.
inline TreePlace anchored(const TreePlace& at, const Vec3& a_W) noexcept {
  return {.p_W = at.p_W,
          .R_WB = at.R_WB,
          .a_W = a_W,
          .V = {.w = at.V.w, .v = at.V.v + at.V.w.cross(a_W - at.a_W)}};
}

/// Sets the axes of a joint.
template <int turns, int slides>
void set_axes(const JointMotion<turns, slides>& m, JointEdge& edge) noexcept {
  edge.num_turns = turns;
  edge.num_axes = turns + slides;
  std::size_t k = 0;
  if constexpr (turns == 3) {
    for (const Column& s : Block::identity().col) edge.s[k++] = s;
  }
  for (const Vec3& s : m.turn) edge.s[k++] = Column(s);
  for (const Vec3& s : m.slide) edge.s[k++] = Column(s);
}

/// Sets the terms of stops (19) at the coordinates q and predicted rates; the stage solves for the rates
/// beyond those.
template <int turns, int slides>
void set_stops(const std::array<StopParams, 2>& stops, const JointMotion<turns, slides>& m,
               const JointCoordinates& q, const Twist& beta, Real h, JointEdge& edge) noexcept {
  std::size_t c = 0;
  const auto set = [&](Real rate) noexcept {
    const AxisTerms t = stop_terms(stops[c], q[static_cast<Eigen::Index>(c)], rate, h);
    edge.stop_D[c] = t.D;
    edge.stop_b[c++] = t.tau + t.D * rate;
  };
  if constexpr (turns < 3) {
    for (const Vec3& s : m.turn) set(s.dot(beta.w));
    for (const Vec3& s : m.slide) set(s.dot(beta.v));
  }
}

/// Adds the joints of an island's bodies, already unknowns of its system, and their stops as terms. A stop is
/// the effective mass D e e^T of the child against the parent, e the wrench on a coordinate.
template <class Contacts, std::size_t N>
void add_bodies_to_parents(const Island& island, BodyContactScratch<Contacts, N>& w) noexcept {
  auto& all = w.graph.joints;
  w.graph.each_body(island, [&](std::uint32_t i, const TouchingContacts&) noexcept {
    JointEdge& edge = all.edges[i];
    BlockJoint& joint = w.system.joints[i];
    joint.is_free = edge.kind == JointKind::free;
    if (joint.is_free) return;
    joint.num_axes = edge.num_axes;
    joint.parent = BlockJoint::on_world;
    if (edge.on_body()) {
      joint.parent = static_cast<std::uint32_t>(edge.parent);
      joint.d = all.p[i] - all.p[edge.parent];
      if (edge.has_stops()) edge.stop_entry = w.system.couple(joint.parent, i);
    }
    for (int a = 0; a < edge.num_axes; ++a)
      joint.s[static_cast<std::size_t>(a)] = axis_twist(edge, a, all.p[i]);
  });
}
template <class Contacts, std::size_t N>
void add_stops(const Island& island, BodyContactScratch<Contacts, N>& w) noexcept {
  const auto& all = w.graph.joints;
  w.graph.each_body(island, [&](std::uint32_t i, const TouchingContacts&) noexcept {
    const JointEdge& edge = all.edges[i];
    for (int k = 0; k < std::min(edge.num_axes, 2); ++k) {
      const Real D = edge.on_coordinate(k);
      if (!(D > 0)) continue;
      const SpatialVector e = axis_wrench(edge, k, all.p[i]), De = e * D;
      const SymmetricSpatialMatrix A{.ww = outer(De.w, e.w), .wv = outer(De.w, e.v), .vv = outer(De.v, e.v)};
      if (edge.on_body()) w.system.add_between(edge.stop_entry, A, w.system.joints[i].d);
      else w.system.add(i, A);
    }
  });
}

/// Calls f(impulse on body i, about its centre of mass) for each stop of its joint, with the coordinate at
/// rest.
template <std::size_t N, class F>
void each_stop(std::size_t i, const JointEdges<N>& joints, F f) noexcept {
  const JointEdge& edge = joints.edges[i];
  for (int k = 0; k < std::min(edge.num_axes, 2); ++k)
    f(axis_wrench(edge, k, joints.p[i]) * edge.stop_b[static_cast<std::size_t>(k)]);
}

/// Motion of a body's anchor against its parent: correction of the violation, and predicted motion along the
/// axes.
struct JointTwists {
  Twist across, along;
};

/// Sets axes and stops of the joint of body i.
template <class Joints, std::size_t N>
JointTwists set_edge(const typename Joints::Params& par, JointsInStage<N, Joints>& tree, std::size_t i,
                     const JointAt& now, Real h, JointEdge& edge) noexcept {
  using Stabilisation = typename Joints::Stabilisation;
  static_assert(!Stabilisation::uses_base, "bodies that touch have their joints at the prediction");
  JointTwists twists;
  with_motion<Joints>(par, tree.prescribed_q, i, [&]([[maybe_unused]] auto kind, auto motion) noexcept {
    const auto m = motion(now.X);
    const Twist beta = Stabilisation::beta(m, now.V, par.C.p.squaredNorm(), h), V_across = across(m, now.V);
    set_axes(m, edge);
    if constexpr (uses<typename Joints::Stops>) {
      if constexpr (requires { kind.coordinates(now.X); }) {
        const JointCoordinates q = counted<decltype(kind)>(now.X, now.V.w, tree.q[i], h);
        set_stops(par.stop.stops, m, q, beta, h, edge);
        tree.stop_changes |= !on_same_branches(par.stop.stops, q, tree.q[i]);
      }
    }
    twists = {.across = across(m, beta), .along = {.w = now.V.w - V_across.w, .v = now.V.v - V_across.v}};
  });
  return twists;
}

/// Adds the geometric stiffness (21), (40) to the stages of the bodies of joint i and to its edge. V_P:
/// predicted twist of the parent. V_rel: predicted twist of the joint. touched: true if a contact was active
/// in the previous step; joint forces then jump, and only the pull along the levers is used.
template <class Contacts, std::size_t N>
void stiffen(JointKind kind, std::size_t i, const Twist& V_P, const Twist& V_rel, const Wrench& F_C, Real h,
             bool touched, bool& is_stiff, BodyContactScratch<Contacts, N>& w) noexcept {
  auto& all = w.graph.joints;
  JointEdge& edge = all.edges[i];
  const bool has_parent = edge.on_body();
  const Column d = has_parent ? edge.a_W - all.edges[edge.parent].a_W : Column(Pack(0));
  BodyStage &child = w.stages[i], &parent = w.stages[has_parent ? edge.parent : i];
  if (touched) {
    if (!has_parent) return;
    const Block K = pull_stiffness(d, -h * h * F_C.f);
    parent.A_ww += K;
    parent.b.w += K * Column(V_P.w);
    return;
  }
  const StiffenedBody<Real> on_child{child.A_ww, child.M, child.b, w.finder.at[i].V},
      on_parent{parent.A_ww, parent.M, parent.b, V_P};
  with_joint(kind, [&](auto of_kind) noexcept {
    const Real K_slide = stiffen<decltype(of_kind.motion(JointFrames{}))>(
        d, (all.p[i] - edge.a_W).vec(), F_C, h, has_parent, on_parent, on_child, is_stiff);
    if (edge.num_axes == edge.num_turns) return;
    const auto slide = static_cast<std::size_t>(edge.num_turns);
    edge.slide_D = K_slide;
    edge.stop_b[slide] += K_slide * dot(edge.s[slide], Column(V_rel.v));
  });
}

/// Begins the joint of body i: its edge, V_p of the body, V_0 that obeys the joint, and the effect of tension
/// and stops on the stages.
template <class S, class Contacts>
void begin_joint(const Params<S>& par, std::size_t i, const Wrench& F_C, bool touched, Real h,
                 TouchingJoints<S::max_bodies, typename S::Joints>& tree,
                 BodyContactScratch<Contacts, S::max_bodies>& w) noexcept {
  auto& all = w.graph.joints;
  JointEdge& edge = all.edges[i];
  const std::size_t parent = edge.parent;
  const TreePlace P = edge.on_body() ? w.finder.at[parent] : TreePlace{};
  const JointAt now = joint_at(par.bodies[i].joint, P, anchored(w.finder.at[i], edge.a_W.vec()));
  const JointTwists twists = set_edge<typename S::Joints>(par.bodies[i].joint, tree, i, now, h, edge);
  const auto relative_motion = [&](const auto& V, const Twist& rel) noexcept {
    SpatialVector V_C{.w = Column(rel.w), .v = Column(rel.v)};
    if (edge.on_body()) V_C = V_C + shifted(V[parent], edge.a_W - all.p[parent]);
    return shifted(V_C, all.p[i] - edge.a_W);
  };
  all.V_p[i] = relative_motion(all.V_p, twists.across);
  w.x.V_0[i] = relative_motion(w.x.V_0, twists.along);
  all.joined[i] = true;
  if (edge.on_body()) {
    all.joined[parent] = true;
    w.finder.owned[i].tree = w.finder.owned[parent].tree;
  }
  stiffen(par.bodies[i].joint.kind, i, P.V, now.V, F_C, h, touched, tree.is_stiff, w);
  each_stop(i, all, [&](const SpatialVector& F) noexcept {
    w.stages[i].b += F;
    if (edge.on_body()) w.stages[parent].b -= moved_wrench(F, all.p[i] - all.p[parent]);
  });
}

/// Begins the joints at the predicted end of the stage, and the bodies' stages for V - V_p. first: use the
/// joint forces (21) of the previous step, otherwise of the previous solve.
template <class S, class Contacts>
void begin_joints(const Params<S>& par, const State<S>& x, bool first, Real h,
                  TouchingJoints<S::max_bodies, typename S::Joints>& tree,
                  BodyContactScratch<Contacts, S::max_bodies>& w) noexcept {
  auto& all = w.graph.joints;
  tree.is_stiff = tree.stop_acts = tree.stop_changes = false;
  for (std::size_t i = 0; i < num_bodies(par); ++i) {
    const typename S::Joints::Params& joint = par.bodies[i].joint;
    const TreePlace& at = w.finder.at[i];
    const bool is_free = joint.kind == JointKind::free;
    JointEdge& edge = all.edges[i];
    edge = {};
    edge.kind = joint.kind;
    edge.parent = is_free ? world : joint.parent;
    edge.a_W = Column(Vec3(at.p_W + at.R_WB * joint.C.p));
    all.p[i] = Column(at.p_W);
    all.joined[i] = false;
    all.V_p[i] = SpatialVector::zero();
  }
  for (std::size_t i = 0; i < num_bodies(par); ++i)
    if (all.edges[i].kind != JointKind::free)
      begin_joint(par, i, first ? x.bodies[i].joint.F_C : Wrench(tree.nodes[i].F_C), x.contacts.size > 0, h,
                  tree, w);
  for (std::size_t i = 0; i < num_bodies(par); ++i)
    if (all.joined[i]) w.stages[i].b -= times(w.stages[i], all.V_p[i]);
}

/// Moves the contact points of an island to the velocities V.
template <class Contacts, std::size_t N>
void shift_contacts(const std::array<SpatialVector, N>& V, Real h, const Island& island,
                    BodyContactScratch<Contacts, N>& w) noexcept {
  each_pack(V, island, w, [&](ContactPack& c, const SpatialVector& V_rel) noexcept {
    move(c, V_rel);
    const Pack v_n = c.n.dot(c.v);
    c.d_0 -= h * v_n;
    c.F_0 -= c.eta_n * v_n;
    c.v_xi += c.v - c.n * v_n;
  });
}

/// Adds the residual impulses on tools without a fixed root to the contact forces of one body per tool, which
/// transfers them. F: impulses on bodies beyond their contact forces, reduced accordingly.
template <class Contacts, std::size_t N, class Impulses>
[[gnu::noinline]] void report_unbalanced_tools(std::size_t num_bodies, Real h, Impulses& F,
                                               BodyContactScratch<Contacts, N>& w) noexcept {
  const auto& all = w.graph.joints;
  Missing<Contacts, N> missing;
  std::array<Vec3, N> before;
  std::array<bool, Missing<Contacts, N>::max> is_near{}, is_on_world{};
  each_link(w, [&](const Link& link) noexcept {
    is_near[link.a] = true;
    if (link.b != Link::on_world) is_near[link.b] = true;
    else is_on_world[link.a] = true;
  });
  for (std::size_t i = 0; i < N; ++i) before[i] = w.wrenches[i].f;
  for (std::size_t root = 0; root < num_bodies; ++root) {
    if (!all.joined[root] || all.edges[root].kind != JointKind::free) continue;
    Vec3 sum = Vec3::Zero();
    std::size_t at = N;
    for (std::size_t i = root; i < num_bodies; ++i) {
      if (!all.joined[i] || w.finder.owned[i].tree != root) continue;
      sum += F[i].v.vec();
      if (is_near[i] && (at == N || (is_on_world[i] && !is_on_world[at]))) at = i;
    }
    if (at < N) missing.F_W[at] = sum * (1 / h);
  }
  pass_on(missing, w);
  for (std::size_t i = 0; i < num_bodies; ++i)
    if (all.joined[i]) F[i].v -= Column(Vec3((w.wrenches[i].f - before[i] + missing.by_net[i]) * h));
}

/// Computes V from V - V_p, and the joint wrenches: the impulse of a body's motion beyond its contacts and
/// terms, plus those of its descendants. F: those impulses, as set by set_missing_impulses().
template <class S, class Contacts>
void end_joints(const Params<S>& par, Real h, BodyContactScratch<Contacts, S::max_bodies>& w,
                TouchingJoints<S::max_bodies, typename S::Joints>& tree) noexcept {
  const auto& all = w.graph.joints;
  auto& F = w.x.Ap;
  for (std::size_t i = 0; i < num_bodies(par); ++i) {
    if (!all.joined[i] || all.edges[i].kind == JointKind::free) continue;
    for (std::size_t k = 0; k < 2; ++k) {
      const Real D = all.edges[i].stop_D[k];
      tree.is_stiff |= D * w.system.joints[i].D_inverse[k] > stiff_stop_share;
      tree.stop_acts |= D > 0;
    }
  }
  if constexpr (Contacts::between_bodies)
    if (w.is_unbalanced) [[unlikely]]
      report_unbalanced_tools(num_bodies(par), h, F, w);
  for (std::uint32_t i = 0; i < num_bodies(par); ++i)
    if (all.joined[i]) w.x.V[i] = w.x.V[i] + all.V_p[i];
  for (std::size_t i = num_bodies(par); i-- > 0;) {
    const JointEdge& edge = all.edges[i];
    if (edge.kind == JointKind::free) continue;
    const Column r = all.p[i] - edge.a_W;
    each_stop(i, all, [&](const SpatialVector& stop) noexcept {
      F[i] = F[i] + stop;
      if (edge.on_body()) F[edge.parent] = F[edge.parent] - moved_wrench(stop, all.p[i] - all.p[edge.parent]);
    });
    const SpatialVector F_a = moved_wrench(F[i], r) * (1 / h);
    tree.nodes[i].F_C = {.tau = F_a.w.vec(), .f = F_a.v.vec()};
    if (edge.on_body()) F[edge.parent] = F[edge.parent] + moved_wrench(F[i], all.p[i] - all.p[edge.parent]);
  }
  if (!w.is_unbalanced) return;
  // a free tool has no joint to the world that could carry the remaining torques and forces
  for (std::size_t i = 0; i < num_bodies(par); ++i) {
    if (!all.joined[i] || all.edges[i].kind != JointKind::free) continue;
    w.wrenches[i].tau += F[i].w.vec() * (1 / h);
    w.wrenches[i].f += F[i].v.vec() * (1 / h);
  }
}

}  // namespace godobject
