// Contacts of nodes of nets in a stage: (24) as for bodies, each with its own velocity, and their terms in
// the system.
#pragma once

#include "core/net/find.h"
#include "core/net/modes.h"
#include "core/solve/begin.h"

namespace godobject {

/// Inputs of a net stage. again: a re-solve (39); with joints, iterations start from the last solution.
template <class Net>
struct NetInput {
  const typename Net::Params& par;
  Vec3 gravity_W;
  bool again = false;
};

template <class Contacts, class Net>
const ContactLaw& law_of(const typename Contacts::Params& contacts, const typename Net::Params& net,
                         const NearContact& near) noexcept {
  if constexpr (Net::max_faces > 0) {
    constexpr std::uint32_t first = first_face_number<Contacts>;
    if (near.on >= first)
      return contacts.law(net.nodes[near.a].material,
                          net.nodes[net.faces.list[near.on - first].nodes[0]].material);
  }
  return contacts.law(net.nodes[near.a].material, contacts.material_of(near.on));
}

/// Returns the velocity of a node from carrier-relative velocities.
template <class V, class Stage>
Column velocity_of_node(const V& of, std::uint32_t n, std::size_t carrier, const Stage& w) noexcept {
  Column v = of[NetNodeNumber{n}];
  if (carrier != world) v += shifted(of[static_cast<std::uint32_t>(carrier)], w.r[n]).v;
  return v;
}
/// Returns the velocity of the point of a face from carrier-relative velocities.
template <class V, class Stage>
Column velocity_at_face(const V& of, const PointOfFace& on, const Stage& w) noexcept {
  Column v(Pack(0));
  for (std::size_t m = 0; m < 3; ++m)
    v += velocity_of_node(of, on.nodes[m], on.carrier, w) * on.weights[static_cast<Eigen::Index>(m)];
  return v;
}

/// Calls f(pack, velocities of its nodes relative to the touched bodies or faces) for all contacts of nets.
template <class V, class Stage, class F>
void each_net_pack(const V& of, Stage& w, F f) noexcept {
  for (std::size_t p = 0; p < w.num_packs; ++p) {
    ContactPack& c = w.packs[p];
    PackVelocity velocity{.v = Vector3<Pack>::Constant(Pack(0)), .number = p};
    for (std::size_t j = 0; j < 4 && 4 * p + j < w.near.size; ++j) {
      const NearContact& near = w.near.list[4 * p + j];
      Column v = velocity_of_node(of, near.a, w.carrier[4 * p + j], w);
      if (const FaceTouch* on = w.touched_face(4 * p + j)) v -= velocity_at_face(of, *on, w);
      else if (near.b != NetContactTerm::on_world) v -= shifted(of[near.b], Column(lane(c.r, j))).v;
      set_lane(velocity.v, j, v.vec());
    }
    f(c, velocity);
  }
}

/// Returns the places of the nodes of pack p at p_W, and of the bodies or faces that they touch, at the
/// predicted end of the stage. Nodes have no attitude: their anchors (51) turn with the touched body or face.
/// face: the face in whose axes the anchors are.
template <class Contacts, std::size_t N>
ContactPlacesOf<Pack> places_of_nodes(const NearFour& near, std::size_t p, const Vector3<Pack>& p_W,
                                      FacePlace FaceTouch::*face,
                                      const BodyContactScratch<Contacts, N>& w) noexcept {
  const TreePlace at_origin{};
  const auto of_touched = [&]<class T>(T FacePlace::*of_face, T TreePlace::*of_body) noexcept {
    return gathered(lanes_of_four, [&](std::size_t j) -> const T& {
      const std::uint32_t b = near.of[j]->b;
      if (const FaceTouch* on = w.net.touched_face(4 * p + std::min<std::size_t>(j, near.size - 1)))
        return (on->*face).*of_face;
      return (b == NetContactTerm::on_world ? at_origin : w.finder.at[b]).*of_body;
    });
  };
  const Matrix3<Pack> R = of_touched(&FacePlace::R_W, &TreePlace::R_WB);
  return {.R_a = R, .R_b = R, .p_a = p_W, .p_b = of_touched(&FacePlace::p_W, &TreePlace::p_W)};
}
/// Returns the positions of four nodes in contact.
template <class Net>
Vector3<Pack> positions_of_nodes(const typename Net::Params& par, const NearFour& near) noexcept {
  const Pack radius = gathered(lanes_of_four, [&](std::size_t j) { return par.nodes[near.of[j]->a].radius; });
  return near.all(&NearContact::p_W) + near.all(&NearContact::n_W) * radius;
}

/// Linearises the near contacts of nets (24), and lists the pairs of a carrier and a touched body.
template <class Contacts, std::size_t N>
void begin_net_contacts(const typename Contacts::Params& par, const NetInput<typename Contacts::Net>& net,
                        Real h, BodyContactScratch<Contacts, N>& w) noexcept {
  auto& of = w.net;
  Recall recall(of.memories.before());
  of.num_packs = (of.near.size + 3) / 4;
  of.num_pairs = 0;
  for (const NetContactTerm& one : of.attached())
    if (one.body != NetContactTerm::on_world)
      find_pair(static_cast<std::uint32_t>(one.carrier), one.body, of);
  Pack found = 0;
  for (std::size_t p = 0; p < of.num_packs; ++p) {
    const NearFour near(&of.near.list[4 * p], of.near.size - 4 * p);
    std::array<StageLawOf<Real>, 4> laws{};
    std::array<Vec3, 4> r, v_W;
    // levers end at the nodes: friction at the surface would turn the body and nothing else
    const Vector3<Pack> nodes_W = positions_of_nodes<typename Contacts::Net>(net.par, near);
    for (std::uint32_t j = 0; j < 4; ++j) {
      const NearContact& one = *near.of[j];
      const std::size_t i = 4 * p + std::min(j, near.size - 1), carrier = net.par.nodes[one.a].body;
      const FaceTouch* const on = of.touched_face(i);
      const bool on_world = one.b == NetContactTerm::on_world;
      Real m = net.par.nodes[one.a].m, M = m;
      std::size_t touched = world;
      r[j].setZero();
      if (on != nullptr) {
        v_W[j] = (of.v[one.a] - at_face(*on, of.v)).vec();
        m = M = std::min(m, mass_at_face(*on, of));
        touched = on->carrier;
      } else {
        const Vec3 p_W = lane(nodes_W, j);
        v_W[j] = of.v[one.a].vec() - velocity_at(w.finder, one.b, p_W);
        if (!on_world) {
          r[j] = p_W - w.finder.at[one.b].p_W;
          m = std::min(m, w.stages[one.b].m);
          M = std::min(M, w.stages[one.b].M);
          touched = one.b;
        }
      }
      if (j >= near.size) continue;
      laws[j] = stage_law<Contacts>(law_of<Contacts, typename Contacts::Net>(par, net.par, one), m, M, h,
                                    w.stage.relaxation_time, on_world);
      of.carrier[i] = carrier;
      if (touched != world && touched != carrier)
        find_pair(static_cast<std::uint32_t>(carrier), static_cast<std::uint32_t>(touched), of);
    }
    const ContactPlacesOf<Pack> places = places_of_nodes(near, p, nodes_W, &FaceTouch::at_memory_face, w);
    ContactStartOf<Pack> start{
        .at = places,
        .n_W = near.all(&NearContact::n_W),
        .v_W = gathered(lanes_of_four, [&](std::size_t j) -> const Vec3& { return v_W[j]; }),
        .rho = 0};
    found += begin_four(near, gathered(laws), near.live(),
                        gathered(lanes_of_four, [&](std::size_t j) -> const Vec3& { return r[j]; }), h,
                        w.stage, start, recall, w.penetration_jumps, of.initial[p], of.packs[p]);
    of.packs[p].u.setConstant(Pack(0));
    of.packs[p].f_slip = 0;
  }
  w.report.found += total(found);
}

/// Declares that nodes of a carrier touch a body, or are attached to it.
template <class Net, std::size_t N>
void find_pair(std::uint32_t carrier, std::uint32_t touched, NetStage<Net, N>& w) noexcept {
  if (carrier >= N) return;  // the world
  for (std::size_t k = w.num_pairs; k-- > 0;)
    if (w.pairs[k].carrier == carrier && w.pairs[k].touched == touched) return;
  // a pair that is left out only makes the preconditioner weaker
  if (w.num_pairs < w.max_pairs) w.pairs[w.num_pairs++] = {.carrier = carrier, .touched = touched};
}

/// Makes the impulses of anchors relative to V_p of jointed bodies.
template <class Twists, class Net, std::size_t N>
void shift_anchors(const Twists& V_p, NetStage<Net, N>& w) noexcept {
  each_carried(w, [&](const NetRun& run) noexcept {
    for (std::uint32_t n = run.first; n < run.end; ++n) {
      const Column J = shifted(V_p[run.body], w.r[n]).v * w.kappa[n];
      w.J_anchor[n] += J;
      w.b[n] += J;
    }
  });
}
/// Makes the initial velocities of contact points relative to V_p of jointed bodies.
template <class Twists, class Net, std::size_t N>
void shift_net_contacts(const Twists& V_p, Real h, NetStage<Net, N>& w) noexcept {
  for (std::size_t i = 0; i < w.near.size; ++i) {
    const NearContact& near = w.near.list[i];
    if (near.b == NetContactTerm::on_world || near.b == NetContactTerm::on_net) continue;
    ContactPack& c = w.packs[i / 4];
    const std::size_t j = i % 4;
    const Vec3 v = -shifted(V_p[near.b], Column(lane(c.r, j))).v.vec();
    const Real v_n = near.n_W.dot(v);
    c.d_0.set(j, c.d_0[j] - h * v_n);
    c.F_0.set(j, c.F_0[j] - c.eta_n[j] * v_n);
    set_lane(c.v_xi, j, lane(c.v_xi, j) + v - near.n_W * v_n);
  }
}

/// Sums the contacts of nets in their modes, as effective masses and impulses, after the attachments.
template <class Net, std::size_t N>
void gather_net_contacts(Real h, NetStage<Net, N>& w) noexcept {
  w.num_contacts = w.num_attachments;
  for (std::size_t i = 0; i < w.near.size; ++i) {
    const ContactPack& c = w.packs[i / 4];
    const std::size_t j = i % 4;
    const Real a = h * c.eta_t[j], b = h * (c.active[j] * c.eta_n[j] - c.eta_t[j]);
    if (!(a > 0) && !(c.active[j] > 0)) continue;
    const Vec3 n = lane(c.n, j);
    const Column J(
        Vec3(n * (h * c.active[j] * c.F_0[j]) - lane(c.v_xi, j) * a - lane(c.u, j) * (h * c.f_slip[j])));
    const FaceTouch* const face = w.touched_face(i);
    w.contacts[w.num_contacts++] = {.node = w.near.list[i].a,
                                    .body = w.near.list[i].b,
                                    .carrier = w.carrier[i],
                                    .face = face != nullptr ? PointOfFace(*face) : PointOfFace{},
                                    .n = Column(n),
                                    .r = Column(lane(c.r, j)),
                                    .a = a,
                                    .b = b,
                                    .J = J};
  }
  if constexpr (Net::max_faces > 0) group_by_terms(w);
}

/// Loads b of bodies, including their carried nodes, and of nodes.
template <class Contacts, std::size_t N>
void load_impulses(BodyContactScratch<Contacts, N>& w) noexcept {
  auto& b = w.coupled_b;
  auto& net = w.net;
  w.system.each([&](std::uint32_t u) noexcept { b.bodies[u] = w.system.b[u]; });
  for (std::uint32_t n = 0; n < net.num_nodes; ++n) b.nodes[n] = net.b[n];
  for (const NetContactTerm& contact : net.terms()) add_impulse(contact, contact.J, b.nodes, b.bodies);
  each_carried(net, [&](const NetRun& run) noexcept {
    SpatialVector sum = SpatialVector::zero();
    for (std::uint32_t n = run.first; n < run.end; ++n)
      sum = sum + moved_wrench({.w = Column(Pack(0)), .v = b.nodes[n] - net.J_anchor[n]}, net.r[n]);
    b.bodies[run.body] = b.bodies[run.body] + sum;
  });
}

/// Loads E of (44): the bodies with their carried nodes.
template <class Contacts, std::size_t N>
void load_carrier_relative(BodyContactScratch<Contacts, N>& w) noexcept {
  auto& net = w.net;
  const auto on_point = [](const Block& A_vv, const Column& r) noexcept {
    SymmetricSpatialMatrix A{.ww = Block::zero(), .wv = Block::zero(), .vv = Block::zero()};
    add_to_parent({.ww = Block::zero(), .wv = Block::zero(), .vv = A_vv}, r, A);
    return A;
  };
  each_carried(net, [&](const NetRun& run) noexcept {
    w.system.add(static_cast<std::uint32_t>(run.body), net.prestress[run.body]);
    w.system.add(static_cast<std::uint32_t>(run.body), inertia_of(net, run));
  });
  for (const NetContactTerm& contact : net.terms()) {
    const Block A = Block::identity() * contact.a + outer(contact.n * contact.b, contact.n);
    const std::size_t carrier = contact.carrier, touched = contact.touched();
    const Column r = net.r[contact.node],
                 r_touched = contact.is_on_face() ? at_face(contact.face, net.r) : contact.r;
    if (contact.is_on_face() && carrier == touched) {
      if (carrier == world) continue;
      // the carrier moves both, except where it turns
      const SymmetricSpatialMatrix turning = on_point(A, r - r_touched);
      w.system.add(static_cast<std::uint32_t>(carrier),
                   {.ww = turning.ww, .wv = Block::zero(), .vv = Block::zero()});
      continue;
    }
    if (carrier != world) w.system.add(static_cast<std::uint32_t>(carrier), on_point(A, r));
    if (touched == world) continue;
    w.system.add(static_cast<std::uint32_t>(touched), on_point(A, r_touched));
    for (std::size_t k = 0; k < net.num_pairs; ++k) {
      const NetPair& pair = net.pairs[k];
      if (pair.carrier != carrier || pair.touched != touched || pair.entry == no_slot) continue;
      // effective mass for the velocity of the carrier's point relative to the touched one
      const SymmetricSpatialMatrix at_end{.ww = Block::zero(), .wv = Block::zero(), .vv = A};
      w.system.add_to_factor(pair.entry, shifted(coupling(at_end, r), r_touched));
    }
  }
}

/// Loads the nodes of an island in a Newton iteration: contacts in their modes, impulses, E and factor.
template <class Contacts, std::size_t N>
void load_nodes(Real h, bool first, BodyContactScratch<Contacts, N>& w) noexcept {
  auto& net = w.net;
  // nodes have moved little since the previous stage, so its factor is as good
  const bool is_factored = !first || (w.stage.continues_step && net.factored_h == h);
  if (!is_factored) {
    gather_net_contacts(h, net);
    factor_nodes(net);
    net.factored_h = h;
  }
  if (first) predict_friction(h, net);  // changes eta_t only
  remove_contacts_from_factor(net);
  gather_net_contacts(h, net);
  find_standing(net);
  add_contacts_to_factor(net);
  load_impulses(w);
  load_carrier_relative(w);
}

/// Transforms the nodes' velocities from world to carrier frame. The function below transforms them back.
template <class Net, std::size_t N, class Vector>
void to_carrier_frame(const NetStage<Net, N>& w, Vector& V) noexcept {
  each_carried(w, [&](const NetRun& run) noexcept {
    for (std::uint32_t n = run.first; n < run.end; ++n) V.nodes[n] -= shifted(V.bodies[run.body], w.r[n]).v;
  });
}
template <class Net, std::size_t N, class Vector>
void to_world_frame(const NetStage<Net, N>& w, Vector& V) noexcept {
  each_carried(w, [&](const NetRun& run) noexcept {
    for (std::uint32_t n = run.first; n < run.end; ++n) V.nodes[n] += shifted(V.bodies[run.body], w.r[n]).v;
  });
}

/// Stores the memory of contacts of nets, their forces on bodies, and the report.
template <class Contacts, std::size_t N>
void end_net(Real h, BodyContactScratch<Contacts, N>& w) noexcept {
  auto& net = w.net;
  auto& next = net.memories.after();
  next.size = net.forces.size = 0;
  NetReport& report = net.report;
  report.num_near = net.near.size;
  for (std::size_t i = 0; i < net.near.size; ++i) {
    const NearContact& near = net.near.list[i];
    const ContactPack& pack = net.packs[i / 4];
    const std::size_t j = i % 4;
    const Vec3 F = lane(pack.F, j);
    const Real depth = pack.d_0[j] - h * near.n_W.dot(lane(pack.v, j));
    report.deepest = std::max(report.deepest, depth);
    const bool bears = near.n_W.dot(F) > 0;
    if (bears) ++report.num_contacts;
    // forces that pull, within the tolerance of the iterations, are attributed to a joint of the body
    bool counts = bears;
    if constexpr (Contacts::jointed) counts = bears || !(near.b < N) || !w.graph.joints.joined[near.b];
    else counts = true;
    if (counts && near.b < N) {
      Wrench& on_body = w.wrenches[near.b];
      on_body.f -= F;
      on_body.tau -= lane(pack.r, j).cross(F);
    }
  }
  for (std::size_t p = 0; p < net.num_packs; ++p) {
    const NearFour near(&net.near.list[4 * p], net.near.size - 4 * p);
    const Vector3<Pack> p_W = positions_of_nodes<typename Contacts::Net>(*net.par, near);
    carry_over(near, near.live(), places_of_nodes(near, p, p_W, &FaceTouch::at_face, w), p_W, w.stage, h,
               net.initial[p], net.packs[p], next);
    add_bearing(near, near.live(), net.packs[p], net.forces);
  }
  each_carried(net, [&](const NetRun& run) noexcept {
    SpatialVector& sum = net.on_carriers[run.body] = SpatialVector::zero();
    for (std::uint32_t n = run.first; n < run.end; ++n) {
      const Column u = w.x.V.nodes[n] - shifted(w.x.V.bodies[run.body], net.r[n]).v;
      const Column J = net.J_anchor[n] - u * net.kappa[n] - w.x.r.nodes[n];
      sum = sum - moved_wrench({.w = Column(Pack(0)), .v = J}, net.r[n]);
    }
  });
  net.passed_on.fill(SpatialVector::zero());
  if (net.num_nodes > 0) report_unbalanced_net(h, w);
}

/// Adds the residual of an iteration, as a force, to the contacts of the bodies and floating nets that it has
/// moved. Joints carry that of their bodies.
template <class Contacts, std::size_t N>
[[gnu::noinline]] void report_unbalanced_net(Real h, BodyContactScratch<Contacts, N>& w) noexcept {
  auto& net = w.net;
  Missing<Contacts, N> missing;
  bool is_missing = false;
  if (!net.is_balanced) {
    w.system.each([&](std::uint32_t i) noexcept {
      is_missing = true;
      if (is_joined(i, w)) return;
      w.wrenches[i].tau -= w.x.r[i].w.vec() * (1 / h);
      missing.F_W[i] = w.x.r[i].v.vec() * (-1 / h);
    });
  }
  for (std::size_t k = 0; k < net.par->num_rows; ++k) {
    if (!net.rows[k].is_free || net.rows[k].flies) continue;
    is_missing = true;
    for (std::uint32_t n = net.par->rows[k].first; n < net.par->rows[k].end; ++n)
      missing.F_W[N + k] -= w.x.r.nodes[n].vec() * (1 / h);
  }
  if (!is_missing) return;
  pass_on(missing, w);
  w.is_unbalanced = true;
  for (std::size_t i = 0; i < N; ++i) net.passed_on[i].v = Column(Vec3(missing.by_net[i] * h));
}

/// Calls f(body, impulse on it about its centre of mass) for the forces of nets on bodies, except contacts.
template <class Contacts, std::size_t N, class F>
void each_net_impulse(const BodyContactScratch<Contacts, N>& w, F f) noexcept {
  each_carried(w.net, [&](const NetRun& run) noexcept {
    f(static_cast<std::uint32_t>(run.body), w.net.on_carriers[run.body]);
  });
  each_attachment_impulse(w.x.V, w.net, f);
  for (std::uint32_t i = 0; i < N; ++i) f(i, w.net.passed_on[i]);
}

}  // namespace godobject
