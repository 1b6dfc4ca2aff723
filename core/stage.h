// One stage of an integrator: from the bases of all bodies to their velocities.
#pragma once

#include "core/body/angular_momentum.h"
#include "core/joint_stage.h"
#include "core/stage_errors.h"
#include "core/stage_scratch.h"

namespace godobject {

/// Kind of a solve. It selects the joint forces in the geometric stiffness (21): of the previous solve, or of
/// the previous step for `first`. It selects the linearisation of joints: at the base's velocities, or at
/// those of the previous solve (39).
enum class Solve : std::uint8_t { first, first_of_substep, again };

/// Solves the tree of joints for the velocities of all bodies (7).
template <Solve which, Scene S>
void solve_tree(const Params<S>& par, const State<S>& x, Real h, Scratch<S>& w) noexcept {
  w.tree.is_stiff = w.tree.stop_acts = w.tree.stop_changes = false;
  for (std::size_t i = num_bodies(par); i-- > 0;) {
    if constexpr (which == Solve::first) eliminate(par.bodies[i].joint, i, x.bodies[i].joint.F_C, h, w.tree);
    else eliminate(par.bodies[i].joint, i, Wrench(w.tree.nodes[i].F_C), h, w.tree);
  }
  for (std::size_t i = 0; i < num_bodies(par); ++i) {
    const StageVelocity V = solve_back(par.bodies[i].joint, i, h, w.tree);
    set_lane(w.velocities[i / lanes<S>].v_W, i % lanes<S>, V.v_W);
    set_lane(w.velocities[i / lanes<S>].w_B, i % lanes<S>, V.w_B);
  }
}

/// Returns the angular velocity at which the skew part of the gyroscopic term acts (34), body axes.
template <Scene S, class T>
Vector3<T> expected_turn(const Matrix3<T>& I_B, [[maybe_unused]] std::size_t g, const StageImpulseOf<T>& J,
                         Real h, [[maybe_unused]] const Scratch<S>& w) noexcept {
  if constexpr (has_stages<S>)
    if (w.turns.known) return w.turns.w_B[g];
  return torque_free_turn(I_B, J, h);
}

/// Sets up the bodies of a group without contacts: predicted places, stage systems, velocities.
template <Scene S, class T>
void load_bodies(const Params<S>& par, std::size_t g, const RigidBodyStateOf<T>& base,
                 const TranslationSystemOf<T>& translation, const RotationSystemOf<T>& rotation,
                 const Matrix3<T>& I_B, [[maybe_unused]] const Vector3<T>& F_W, Real h, Real max_turn,
                 Scratch<S>& w) noexcept {
  const TreePlaceOf<T> at = place<T>(Vector3<T>::Zero(), predicted(base, h, max_turn));
  const RigidBodyStateOf<T> middle = predicted(base, Real(0.5) * h, Real(0.5) * max_turn);
  const Matrix3<T> R = middle.X_WB.q.toRotationMatrix();
  const Matrix3<T> A_W = R * rotation.A_B * R.transpose();
  const Vector3<T> b_w = R * rotation.b_B;
  const Vector3<T> w_W = solve3<T>(A_W, b_w), v_W = translation.b_W * T(1 / translation.M);
  Matrix3<T> A_s = Real(0.5) * (A_W + A_W.transpose());
  // (34)
  StageImpulseOf<T>& J = w.impulses[g];
  J = stage_impulse<T>(I_B, w.bases[g].w_B, rotation.hw_B, middle.X_WB.q, h);
  J.turn_B = expected_turn(I_B, g, J, h, w);
  Vector3<T> b_s = b_w - R * J.skew_B.cross(J.turn_B);
  if constexpr (has_stages<S>) {
    if (w.turns.known) b_s = A_s * w_W - (A_W - A_s) * (R * w.turns.w_B[g] - w_W);
  }
  if constexpr (uses<typename S::Joints>) {
    const GroupIn<S> group(g, num_bodies(par));
    const Vector3<T>& p_C =
        gathered(group, [&](std::size_t i) -> const Vec3& { return par.bodies[i].joint.C.p; });
    stiffen<false, T>(-(R * p_C), h * h * F_W, at.V.w, A_s, b_s);
  }
  const auto A_0 = columns(A_s.col(0).eval()), A_1 = columns(A_s.col(1).eval()),
             A_2 = columns(A_s.col(2).eval());
  const auto b_w_W = columns(b_s), b_v_W = columns(translation.b_W), w_0 = columns(w_W), v_0 = columns(v_W);
  for (std::size_t j = 0; j < num_lanes<T> && g * num_lanes<T> + j < num_bodies(par); ++j) {
    const std::size_t i = g * num_lanes<T> + j;
    TreePlace& place = w.contacts.finder.at[i];
    place = lane(at, j);
    auto& owned = w.contacts.finder.owned[i];
    owned.tree = static_cast<std::uint32_t>(i);
    w.contacts.stages[i] = {.A_ww = {{A_0[j], A_1[j], A_2[j]}},
                            .M = lane(translation.M, j),
                            .b = {.w = b_w_W[j], .v = b_v_W[j]},
                            .m = par.bodies[i].body.m};
    w.contacts.x.V[i] = {.w = w_0[j], .v = v_0[j]};
    w.contacts.x.V_0[i] = {.w = Column(place.V.w), .v = Column(place.V.v)};
    owned.beyond_predicted = {.w = w_0[j].vec() - place.V.w, .v = v_0[j].vec() - place.V.v};
  }
}

/// Sets the mean velocities of bodies since the start of the step, from their poses then and at the predicted
/// end. The predicted velocity is the mean one in stages that follow another.
template <Scene S>
void set_mean_velocities(const Params<S>& par, const State<S>& x, Real h, Scratch<S>& w) noexcept {
  auto& finder = w.contacts.finder;
  const Real swept = w.contacts.stage.swept;
  for (std::uint32_t i = 0; i < num_bodies(par); ++i) {
    const Vec3& p_W = finder.at[i].p_W;
    finder.owned[i].mean_beyond_predicted =
        swept > 0 ? Vec3((p_W - x.bodies[i].x.X_WB.p) / (swept + h) - velocity_at(finder, i, p_W))
                  : Vec3(Vec3::Zero());
  }
}

/// Returns coordinate c of the joint of body i at the predicted end of a stage.
template <Scene S>
CoordinateAt coordinate_at([[maybe_unused]] const Params<S>& par, std::uint32_t i, [[maybe_unused]] int c,
                           [[maybe_unused]] Real h, [[maybe_unused]] const Scratch<S>& w) noexcept {
  CoordinateAt at{.child = i};
  if constexpr (counts_turns<S>) {
    const JointParams& joint = par.bodies[i].joint;
    const auto& places = w.contacts.finder.at;
    const bool has_parent = joint.parent != world;
    at.a_W = places[i].p_W + places[i].R_WB * joint.C.p;
    if (has_parent) at.parent = static_cast<std::uint32_t>(joint.parent);
    const JointAt now =
        joint_at(joint, has_parent ? places[joint.parent] : TreePlace{}, anchored(places[i], at.a_W));
    with_joint(joint.kind, [&]<class Kind>(Kind) noexcept {
      if constexpr (requires(const JointFrames& X) { Kind::coordinates(X); }) {
        const auto m = Kind::motion(now.X);
        at.is_turn = c < decltype(m)::num_turns;
        for (int k = 0; k < decltype(m)::num_turns; ++k)
          if (k == c) at.s_W = m.turn[static_cast<std::size_t>(k)];
        for (int k = 0; k < decltype(m)::num_slides; ++k)
          if (k + decltype(m)::num_turns == c) at.s_W = m.slide[static_cast<std::size_t>(k)];
        at.q = counted<Kind>(now.X, now.V.w, w.tree.q[i], h)[c];
        at.rate = at.s_W.dot(at.is_turn ? now.V.w : now.V.v);
      }
    });
  }
  return at;
}

/// Solves a stage with contacts and terms. Compiled once for all stages of a step.
template <Scene S>
[[gnu::noinline]] void solve_touching(const Params<S>& par, const State<S>& x, [[maybe_unused]] Solve which,
                                      Real h, Scratch<S>& w) noexcept {
  auto& contacts = w.contacts;
  set_mean_velocities(par, x, h, w);
  if constexpr (uses<typename S::Joints>) begin_joints(par, x, which == Solve::first, h, w.tree, contacts);
  if constexpr (uses<TermsOf<S>>) {
    const auto coordinate = [&](std::uint32_t i, int c) noexcept { return coordinate_at(par, i, c, h, w); };
    begin_terms(par.terms, which == Solve::first ? x.terms : w.term_forces, h, coordinate, contacts);
  }
  if constexpr (uses<NetOf<S>>) {
    const NetInput<NetOf<S>> net{par.net, par.gravity_W, which == Solve::again};
    begin_net(net, w.net.bases, h, contacts);
    solve_contacts(par.contacts, num_bodies(par), h, contacts, net);
    end_contacts(h, contacts);
    end_net(h, contacts);
  } else {
    solve_contacts(par.contacts, num_bodies(par), h, contacts);
    end_contacts(h, contacts);
  }
  if constexpr (uses<TermsOf<S>>) end_terms(h, contacts, w.term_forces);
  if constexpr (uses<TermsOf<S>> || uses<typename S::Joints>)
    set_missing_impulses(num_bodies(par), h, contacts);
  if constexpr (uses<TermsOf<S>>)
    if (!contacts.is_unbalanced) balance_flight(num_bodies(par), contacts);
  if constexpr (uses<typename S::Joints>) end_joints(par, h, contacts, w.tree);
  for (std::size_t i = 0; i < num_bodies(par); ++i) {
    const SpatialVector& V = contacts.x.V[i];
    const std::size_t g = i / lanes<S>, j = i % lanes<S>;
    const Vec3 w_B = to_body<Real>(lane(w.impulses[g].q_WM, j), V.w.vec());
    set_lane(w.velocities[g].v_W, j, V.v.vec());
    set_lane(w.velocities[g].w_B, j, w_B);
    // a body without contacts has the full (11)
    if (!is_in_island(static_cast<std::uint32_t>(i), contacts)) set_lane(w.impulses[g].turn_B, j, w_B);
    if (is_joined(static_cast<std::uint32_t>(i), contacts)) set_lane(w.impulses[g].is_joined, j, 1);
  }
}

/// Begins the contacts of a stage from their memories at the end of the previous one.
template <Scene S>
void begin_stage(const ContactStage& stage, [[maybe_unused]] const State<S>& x, Scratch<S>& w) noexcept {
  if constexpr (uses<ContactsOf<S>>) {
    w.contacts.stage = stage;
    w.contacts.stage.found = stage.continues_step ? w.contacts.report.found : 0;
    if (stage.continues_step) w.contacts.memories.next_stage();
    else w.contacts.memories.start(x.contacts);
  }
  if constexpr (uses<NetOf<S>>) {
    if (stage.continues_step) w.contacts.net.memories.next_stage();
    else w.contacts.net.memories.start(x.net.contacts);
  }
}

/// Restores the attitude errors of the previous step, by which a stage keeps its side near the half turn.
template <Scene S>
void recall_errors(const GroupIn<S>& group, const State<S>& x, Next<S>& next) noexcept {
  if constexpr (uses<typename S::Coupling>)
    next.coupling.phi_B =
        gathered(group, [&](std::size_t i) -> const Vec3& { return x.bodies[i].coupling.phi_B; });
}

/// Solves (10) and (11), linearised once, for every body over a time h from w.bases. target_of(g): targets of
/// group g at the end of the stage. w.next: attitude errors of the previous stage, replaced by those of this
/// one.
template <Solve which = Solve::first, Scene S, class TargetOfGroup>
void solve_once(const Params<S>& par, const State<S>& x, Real h, const TargetOfGroup& target_of,
                Scratch<S>& w) noexcept {
  using T = Lanes<S>;
  for (std::size_t g = 0; g < num_groups(par); ++g) {
    const GroupIn<S> group(g, num_bodies(par));
    const RigidBodyParamsOf<T>& body =
        gathered(group, [&](std::size_t i) -> const RigidBodyParams& { return par.bodies[i].body; });
    const RigidBodyStateOf<T>& base = w.bases[g];
    Vector3<T> F_W = body.m * par.gravity_W;
    Vector3<T> tau_B = Vector3<T>::Zero();
    if constexpr (uses<typename S::Device>) {
      F_W += gathered(group, [&](std::size_t i) -> const Vec3& { return w.coupling_inputs[i].F_WB.f; });
      tau_B = to_body<T>(base.X_WB.q, gathered(group, [&](std::size_t i) -> const Vec3& {
                           return w.coupling_inputs[i].F_WB.tau;
                         }));
    }

    SpringParamsOf<T> spring;
    Vector3<T> e_W = Vector3<T>::Zero(), v_D = Vector3<T>::Zero(), w_D_B = Vector3<T>::Zero();
    RotationErrorOf<T> error;
    [[maybe_unused]] std::conditional_t<counts_errors<S>, Vector3<T>, Absent<0>> turns_B;
    if constexpr (uses<typename S::Coupling>) {
      const TargetOf<T>& target = target_of(g);
      spring = gathered(
          group, [&](std::size_t i) { return ramped(par.bodies[i].coupling, w.coupling_inputs[i].ramp.s); });
      e_W = target.X_WD.p - base.X_WB.p;
      v_D = target.V_WD.v;
      w_D_B = to_body<T>(base.X_WB.q, target.V_WD.w);
      if constexpr (counts_errors<S>) w.errors.before[g] = w.next[g].coupling.phi_B;
      error = rotation_error<T>(base.X_WB.q, target.X_WD.q, w.next[g].coupling.phi_B);
      w.next[g].coupling.phi_B = error.phi_B;
      if constexpr (counts_errors<S>) {
        w.errors.are_large = (g == 0 ? w.errors.has_turns : w.errors.are_large) ||
                             any(error.phi_B.squaredNorm() > large_error_sq);
        if (w.errors.are_large) [[unlikely]]
          turns_B = count_turns(par, g, target_of, error, w);
      }
    }

    const TranslationSystemOf<T> translation =
        implicit_translation(body.m, spring, base.v_W, e_W, v_D, F_W, h);
    const Vector3<T> F_0 = F_W + T(spring.k) * e_W;  // force at the start of the stage
    constexpr TorqueAxes axes = uses<ContactsOf<S>> ? TorqueAxes::middle : TorqueAxes::end;
    RotationSystemOf<T> rotation = implicit_rotation<axes>(body, spring, base.w_B, error, w_D_B, tau_B, h);
    if constexpr (counts_errors<S>) {
      if (w.errors.are_large) [[unlikely]]
        add_turns<axes, T>(spring, turns_B, h, rotation);
    }
    constexpr Real max_turn = which == Solve::again ? max_iterated_turn : max_predicted_turn;
    const auto point = [&]() noexcept -> decltype(auto) {
      if constexpr (which != Solve::again) return (base);
      else return RigidBodyStateOf<T>{base.X_WB, w.velocities[g].v_W, w.velocities[g].w_B};
    };
    if constexpr (uses<ContactsOf<S>>) {
      load_bodies<S, T>(par, g, point(), translation, rotation, body.I_B, F_0, h, max_turn, w);
    } else if constexpr (uses<typename S::Joints>) {
      load(par, g, point(), translation, rotation, F_0, h, max_turn, w.tree);
    } else {
      w.velocities[g] = {.v_W = translation.b_W * T(1 / translation.M),
                         .w_B = solve3<T>(rotation.A_B, rotation.b_B)};
    }
  }
  if constexpr (uses<ContactsOf<S>>) {
    solve_touching(par, x, which, h, w);
  } else if constexpr (uses<typename S::Joints>) {
    solve_tree<which>(par, x, h, w);
  }
}

/// Returns the inertia of a group of bodies, body axes.
template <Scene S>
decltype(auto) inertia(const Params<S>& par, std::size_t g) noexcept {
  return gathered(GroupIn<S>(g, num_bodies(par)),
                  [&](std::size_t i) -> const Mat3& { return par.bodies[i].body.I_B; });
}

/// Returns the bodies of a group at the end of the solved stage of length h.
template <Scene S>
RigidBodyStateOf<Lanes<S>> end_of_stage([[maybe_unused]] const Params<S>& par, std::size_t g, Real h,
                                        const Scratch<S>& w) noexcept {
  using T = Lanes<S>;
  const RigidBodyStateOf<T>& base = w.bases[g];
  const StageVelocityOf<T>& V = w.velocities[g];
  RigidBodyStateOf<T> end{.X_WB = moved<T>(base.X_WB, V.v_W, V.w_B, h), .v_W = V.v_W, .w_B = V.w_B};
  if constexpr (uses<ContactsOf<S>>) {
    const Matrix3<T>& I_B = inertia(par, g);
    end.w_B = angular_velocity_after<T>(I_B, w.impulses[g], base, V.w_B, end.X_WB.q);
  }
  return end;
}

/// Sets the prescribed joint coordinates for the coming stage, which ends at the fraction s of the step.
template <Scene S>
void prescribe_joints(const Params<S>& par, Real s, Scratch<S>& w) noexcept {
  if constexpr (prescribes<S>) {
    for (std::size_t i = 0; i < num_bodies(par); ++i)
      w.tree.prescribed_q[i] = interpolated(w.prescribed[i], s, par.h);
  }
}

/// Sets the applied forces for the coming stage, which ends at the fraction s of the step.
template <Scene S>
void prescribe_forces(const Params<S>& par, Real s, Scratch<S>& w) noexcept {
  if constexpr (uses<typename S::Device>) {
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      const Wrench &F_0 = w.coupling_inputs[i].F_0_WB, &F_1 = w.coupling_inputs[i].F_1_WB;
      w.coupling_inputs[i].F_WB = {.tau = F_1.tau - (1 - s) * (F_1.tau - F_0.tau),
                                   .f = F_1.f - (1 - s) * (F_1.f - F_0.f)};
    }
  }
}

/// Copies the joint coordinates at the start of the step, and the turns by which targets lead them. Engaging
/// begins on the nearest turn.
template <Scene S>
void start_coordinates(const Params<S>& par, const State<S>& x, Scratch<S>& w) noexcept {
  if constexpr (counts_turns<S>) {
    for (std::size_t i = 0; i < num_bodies(par); ++i) w.tree.q[i] = x.bodies[i].joint.q;
  }
  if constexpr (counts_errors<S>) {
    w.errors.has_turns = false;
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      w.errors.turns[i] = w.coupling_inputs[i].fresh ? TurnsAhead{} : x.bodies[i].joint.ahead;
      w.errors.has_turns |= w.errors.turns[i].any();
    }
  }
}

/// Updates the joint coordinates over a time t, s, to the bodies' places at(i).
template <Scene S, class StateOfBody>
void follow_coordinates(const Params<S>& par, Real t, const StateOfBody& at, Scratch<S>& w) noexcept {
  if constexpr (counts_turns<S>) {
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      const JointParams& joint = par.bodies[i].joint;
      with_joint(joint.kind, [&]<class Kind>(Kind) noexcept {
        if constexpr (requires(const JointFrames& X) { Kind::coordinates(X); }) {
          const Vec3& p_P = joint.parent == world ? joint.C.p : par.bodies[joint.parent].joint.C.p;
          const TreePlace P = joint.parent == world ? TreePlace{} : place<Real>(p_P, at(joint.parent));
          const JointAt now = joint_at(joint, P, place<Real>(joint.C.p, at(i)));
          const JointCoordinates q = counted<Kind>(now.X, now.V.w, w.tree.q[i], t);
          w.tree.stop_changes |= !on_same_branches(par.bodies[i].joint.stop.stops, q, w.tree.q[i]);
          w.tree.q[i] = q;
        }
      });
    }
  }
}

/// Updates the joint coordinates to the end of the step, a time t, s, after those stored.
template <Scene S>
void end_coordinates(const Params<S>& par, Real t, Scratch<S>& w) noexcept {
  follow_coordinates(
      par, t, [&w](std::size_t i) { return lane(w.next[i / lanes<S>].x, i % lanes<S>); }, w);
}

/// Returns the targets at the end of the step, by group.
template <Scene S>
auto targets_at_the_end(const Params<S>& par, const Scratch<S>& w) noexcept {
  return [&](std::size_t g) -> decltype(auto) {
    return gathered(GroupIn<S>(g, num_bodies(par)),
                    [&w](std::size_t i) -> const Target& { return w.coupling_inputs[i].to; });
  };
}

}  // namespace godobject
