// TR-BDF2: second order, L-stable, two implicit Euler stages per step (docs/theory/tr_bdf2.md).
//
//   (12)  stage 1, trapezoidal rule to c h:   base = y_n + d h K_0,            move d h to y_1
//   (13)  stage 2, BDF2 to h:                 base = y_n + b h (K_0 + K_1),    move d h to y_n+1
//
// d = 1 - 1/sqrt 2, c = 2 d, b = sqrt 2 / 4. K = (velocity, acceleration) at the start and after stage 1. K_0
// is the end of stage 2 of the previous step. The first step of a run or an engagement has no K_0. It takes
// the two stages of the SDIRK scheme with the same d, also of second order and L-stable:
//
//         stage 1, implicit Euler to d h:   base = y_n,                      move d h to y_1
//         stage 2, SDIRK to h:              base = y_n + (1 - d) h K_1,      move d h to y_n+1
//
// If a step rotates a body too far for linear extrapolation, or if forces jump, the stages are implicit Euler
// steps of c h and (1 - c) h. These cannot increase the energy, and the step reports Limited::first_order.
#pragma once

#include "core/node_stage.h"
#include "core/solve_stage.h"

namespace godobject {

struct TrBdf2 {
  static constexpr const char* name = "tr-bdf2";
  static constexpr int order = 2;
  template <class T>
  struct MemoryOf {
    Vector3<T> a_W = Vector3<T>::Zero();      // K_0: acceleration, m/s^2
    Vector3<T> alpha_B = Vector3<T>::Zero();  // K_0: angular acceleration in body axes, rad/s^2
    bool known = false;                       // false before the first step and when the force has jumped

    MemoryOf<Real> of_lane(std::size_t j) const noexcept {
      return {.a_W = lane(a_W, j), .alpha_B = lane(alpha_B, j), .known = known};
    }
    friend T sum(const MemoryOf& m) noexcept { return m.a_W.sum() + m.alpha_B.sum(); }
  };
  using Memory = MemoryOf<Real>;
  using NodeMemory = Vec3;  // K_0: acceleration, m/s^2

  static constexpr Real d = 0.29289321881345248;
  static constexpr Real c = 2 * d;
  static constexpr Real b = 0.35355339059327376;

  /// Advances all bodies by one step, from x to w.next, through the targets of w.coupling_inputs.
  template <Scene S>
  static Limited advance(const Params<S>& par, const State<S>& x, Scratch<S>& w) noexcept {
    const Begin begin = first_acceleration(par, x, w);
    const StepEnd end = solve_stages(begin, par, x, w);
    if (end == StepEnd::unsolved) [[unlikely]]
      solve_stages_as_euler(par, x, w);
    return end == StepEnd::second_order ? Limited::none : Limited::first_order;
  }

 private:
  enum class Begin : std::uint8_t { from_memory, without_acceleration, two_euler_stages };
  enum class StepEnd : std::uint8_t {
    second_order,
    first_order,  // a stage, or both, were implicit Euler steps
    // Retake the step as two implicit Euler stages. Reasons: the set of active contacts or stops (19)
    // changed, joints did not converge (39), net springs gained energy (46), or a body left the searched
    // region.
    unsolved
  };

  /// True if a step without K_0 may use SDIRK. Not with joints or contacts: their forces at t_n are unknown,
  /// and extrapolating them from stage 1 may add energy.
  template <class S>
  static constexpr bool starts_without_acceleration = !uses<ContactsOf<S>> && !uses<typename S::Joints>;

  /// Returns the end of the first stage as a share of the step.
  static Real first_end(Begin begin) noexcept { return begin == Begin::without_acceleration ? d : c; }

  /// Solves both stages as implicit Euler steps. Not inlined: keeps the fallback out of the hot path.
  template <Scene S>
  [[gnu::noinline]] static void solve_stages_as_euler(const Params<S>& par, const State<S>& x,
                                                      Scratch<S>& w) noexcept {
    solve_stages(Begin::two_euler_stages, par, x, w);
  }

  /// Solves both stages from the start that `begin` selects.
  template <Scene S>
  static StepEnd solve_stages(Begin begin, const Params<S>& par, const State<S>& x, Scratch<S>& w) noexcept {
    const Real h = par.h;
    const bool smooth = begin != Begin::two_euler_stages;

    // (12)
    const StageEnd first = solve_first_stage(begin, par, x, w);
    if (!first.solved || (smooth && (has_penetration_jump(w) || stop_changes(w)))) return StepEnd::unsolved;
    const Real h_1 = first.h;

    // (13)
    bool still_smooth = smooth && turns_are_small(par, w);
    if constexpr (uses<ContactsOf<S>>) {
      if (smooth && !have_same_active_contacts(x.contacts, w.contacts.memories.after()))
        return StepEnd::unsolved;
    }
    if constexpr (uses<NetOf<S>>) {
      if (smooth && w.contacts.net.report.majorised) return StepEnd::unsolved;
      still_smooth =
          still_smooth && have_same_active_contacts(x.net.contacts, w.contacts.net.memories.after());
    }
    const Real h_2 = still_smooth ? d * h : (1 - first_end(begin)) * h;
    if constexpr (has_stages<S>) w.turns.known = still_smooth;
    if (still_smooth) extend_bases(begin, par, x, h_1, h_2, w);
    else follow_bases(par, x, h_1, w);
    prescribe_joints(par, 1, w);
    prescribe_forces(par, 1, w);
    begin_stage<S>({.relaxation_time = (1 - c) * h,
                    .extrapolated = still_smooth ? 2 * (b - d) * h : 0,  // from y_1 to the base
                    .swept = still_smooth ? 2 * b * h : 0,
                    .continues_step = true},
                   x, w);
    const StageEnd last = solve_stage(par, x, h_2, !still_smooth, targets_at_the_end(par, w), w);
    if (!last.solved || (still_smooth && has_penetration_jump(w))) return StepEnd::unsolved;
    for (std::size_t g = 0; g < num_groups(par); ++g) w.next[g].x = end_of_stage(par, g, last.h, w);
    end_coordinates(par, still_smooth ? h : last.h, w);
    if (still_smooth && stop_changes(w)) return StepEnd::unsolved;
    if constexpr (uses<NetOf<S>>)
      if (still_smooth && w.contacts.net.report.majorised) return StepEnd::unsolved;

    for (std::size_t g = 0; g < num_groups(par); ++g) {
      Next<S>& next = w.next[g];
      next.memory = {.a_W = (w.velocities[g].v_W - w.bases[g].v_W) * (1 / h_2),
                     .alpha_B = last_acceleration(par, g, h_2, w),
                     .known = is_acceleration_valid(w) && last.acceleration_valid};
    }
    end_nodes(par, x, last.h, w);
    add_to_means(par, last.h / h, w);
    if constexpr (uses<ContactsOf<S>>) {
      if (smooth && !have_same_active_contacts(w.contacts.memories)) return StepEnd::unsolved;
    }
    return still_smooth ? StepEnd::second_order : StepEnd::first_order;
  }

  /// Extrapolates the bases of the second stage (13). h_1, h_2: lengths of the first and second stage, s.
  template <Scene S>
  static void extend_bases(Begin begin, const Params<S>& par, const State<S>& x, Real h_1,
                           [[maybe_unused]] Real h_2, Scratch<S>& w) noexcept {
    using T = Lanes<S>;
    for (std::size_t g = 0; g < num_groups(par); ++g) {
      const StageVelocityOf<T>& V_1 = w.velocities[g];
      const Start<S> y(GroupIn<S>(g, num_bodies(par)), x);
      const Vector3<T> a_1 = (V_1.v_W - w.bases[g].v_W) * (1 / h_1);
      if constexpr (has_stages<S>) {
        // (64)
        const Matrix3<T>& I_B = inertia(par, g);
        const RigidBodyStateOf<T> y_1 = end_of_stage(par, g, h_1, w);
        const Vector3<T> T_1 = torque_of_stage<T>(I_B, w.bases[g], y_1, h_1);
        const Vector3<T> L_W =
            angular_momentum<T>(I_B, y.x) + T(b * par.h) * (torque<T>(I_B, y.x, y.alpha_B) + T_1);
        RigidBodyStateOf<T>& base = w.bases[g];
        base.X_WB = moved<T>(moved<T>(y.x.X_WB, y.x.v_W, y.x.w_B, b * par.h), V_1.v_W, y_1.w_B, b * par.h);
        base.v_W = y.x.v_W + T(b * par.h) * (y.a_W + a_1);
        base.w_B = angular_velocity<T>(I_B, base.X_WB.q, L_W);
        w.turns.w_B[g] = base.w_B + h_2 * acceleration<T>(I_B, base, T_1);
        continue;
      }
      const Vector3<T> alpha_1 = (V_1.w_B - w.bases[g].w_B) * (1 / h_1);
      if (starts_without_acceleration<S> && begin == Begin::without_acceleration)
        w.bases[g] = extrapolated<T>(y.x, V_1.v_W, V_1.w_B, a_1, alpha_1, (1 - d) * par.h);
      else
        w.bases[g] = extrapolated<T>(y.x, y.x.v_W + V_1.v_W, y.x.w_B + V_1.w_B, y.a_W + a_1,
                                     y.alpha_B + alpha_1, b * par.h);
    }
    extend_nodes(par, x, b * par.h, h_1, w);
    add_to_means(par, h_1 / par.h, w);
    scale_means(par, b / d, w);
  }

  /// Solves the first stage (12); without K_0, an implicit Euler step of d h or c h.
  template <Scene S>
  static StageEnd solve_first_stage(Begin begin, const Params<S>& par, const State<S>& x,
                                    Scratch<S>& w) noexcept {
    using T = Lanes<S>;
    const bool smooth = begin != Begin::two_euler_stages;
    const Real h = par.h;
    const Real h_1 = smooth ? d * h : c * h;
    const Real dh = begin == Begin::from_memory ? d * h : 0;
    const Real end = first_end(begin);
    for (std::size_t g = 0; g < num_groups(par); ++g) {
      const GroupIn<S> group(g, num_bodies(par));
      const Start<S> y(group, x);
      w.bases[g] = extrapolated<T>(y.x, y.x.v_W, y.x.w_B, y.a_W, y.alpha_B, dh);
      if constexpr (has_stages<S>) {
        const Matrix3<T>& I_B = inertia(par, g);
        if (dh > 0)
          w.bases[g].w_B = angular_velocity<T>(
              I_B, w.bases[g].X_WB.q, angular_momentum<T>(I_B, y.x) + T(dh) * torque<T>(I_B, y.x, y.alpha_B));
        w.turns.w_B[g] = w.bases[g].w_B + y.alpha_B * h_1;
      }
      recall_errors<S>(group, x, w.next[g]);
      if constexpr (uses<typename S::Device>)
        w.inside[g] = interpolated<T>(
            gathered(group, [&w](std::size_t i) -> const Target& { return w.coupling_inputs[i].from; }),
            gathered(group, [&w](std::size_t i) -> const Target& { return w.coupling_inputs[i].to; }), end,
            h);
    }
    start_nodes(par, x, dh, w);
    start_coordinates(par, x, w);
    begin_means(par, x, dh / h, w);
    prescribe_joints(par, end, w);
    prescribe_forces(par, end, w);
    if constexpr (has_stages<S>) w.turns.known = smooth;
    begin_stage<S>(
        {.relaxation_time = c * h, .extrapolated = dh, .swept = dh, .slip_before = smooth ? Real(0.5) : 0}, x,
        w);
    const auto inside = [&w](std::size_t g) -> const TargetOf<T>& { return w.inside[g]; };
    return solve_stage(par, x, h_1, !smooth, inside, w);
  }

  /// State y_n and slope K_0 of a group.
  template <class S>
  struct Start {
    using T = Lanes<S>;
    // reference instead of a copy if the group is a single body
    template <class U>
    using Held = std::conditional_t<num_lanes<T> == 1, const U&, U>;
    Held<RigidBodyStateOf<T>> x;
    Held<Eigen::Matrix<T, 3, 1>> a_W, alpha_B;

    Start(const GroupIn<S>& group, const State<S>& y) noexcept
        : x(gathered(group, [&](std::size_t i) -> const RigidBodyState& { return y.bodies[i].x; })),
          a_W(gathered(group, [&](std::size_t i) -> const Vec3& { return y.bodies[i].memory.a_W; })),
          alpha_B(gathered(group, [&](std::size_t i) -> const Vec3& { return y.bodies[i].memory.alpha_B; })) {
    }
  };

  /// Returns the torque on a body of the angular acceleration alpha, world axes.
  template <class T>
  static Vector3<T> torque(const Matrix3<T>& I_B, const RigidBodyStateOf<T>& x,
                           const Vector3<T>& alpha_B) noexcept {
    return to_world<T>(x.X_WB.q, Vector3<T>(I_B * alpha_B + x.w_B.cross(I_B * x.w_B)));
  }
  /// Returns the angular acceleration by a torque, body axes.
  template <class T>
  static Vector3<T> acceleration(const Matrix3<T>& I_B, const RigidBodyStateOf<T>& x,
                                 const Vector3<T>& T_W) noexcept {
    return solve3<T>(I_B, Vector3<T>(to_body<T>(x.X_WB.q, T_W) - x.w_B.cross(I_B * x.w_B)));
  }
  /// Returns the mean torque from a base to the end of a stage of length h, world axes.
  template <class T>
  static Vector3<T> torque_of_stage(const Matrix3<T>& I_B, const RigidBodyStateOf<T>& base,
                                    const RigidBodyStateOf<T>& end, Real h) noexcept {
    return (angular_momentum<T>(I_B, end) - angular_momentum<T>(I_B, base)) * (1 / h);
  }

  /// Returns the angular acceleration at the end of the step, after the last stage of length h.
  template <Scene S>
  static Vector3<Lanes<S>> last_acceleration([[maybe_unused]] const Params<S>& par, std::size_t g, Real h,
                                             const Scratch<S>& w) noexcept {
    using T = Lanes<S>;
    if constexpr (has_stages<S>) {
      const Matrix3<T>& I_B = inertia(par, g);
      return acceleration<T>(I_B, w.next[g].x, torque_of_stage<T>(I_B, w.bases[g], w.next[g].x, h));
    } else {
      return (w.velocities[g].w_B - w.bases[g].w_B) * (1 / h);
    }
  }

  /// Returns y + t K.
  template <class T>
  static RigidBodyStateOf<T> extrapolated(const RigidBodyStateOf<T>& y, const Vector3<T>& v_W,
                                          const Vector3<T>& w_B, const Vector3<T>& a_W,
                                          const Vector3<T>& alpha_B, Real t) noexcept {
    return {.X_WB = moved<T>(y.X_WB, v_W, w_B, t), .v_W = y.v_W + t * a_W, .w_B = y.w_B + t * alpha_B};
  }

  /// True if h |w| is small enough for an extrapolated step.
  template <Scene S>
  static bool turn_is_small(const BodyParams<S>& par, const Vec3& w_B, Real h) noexcept {
    SpringParams coupling;
    if constexpr (uses<typename S::Coupling>) coupling = par.coupling;
    const Real max_turn = max_extrapolated_turn_of(par.body, coupling, uses<NetOf<S>>);
    return h * h * w_B.squaredNorm() <= max_turn * max_turn;
  }

  /// True if a contact is deeper than the motion explains (35). The step is then retaken as two Euler stages.
  template <Scene S>
  static bool has_penetration_jump(const Scratch<S>& w) noexcept {
    if constexpr (checks_penetration_jumps<TouchingOf<S>>) return w.contacts.penetration_jumps;
    return false;
  }

  /// True if a stop (19) became active or inactive in a stage. K_0 belongs to the previous law; a base that
  /// it extrapolates deep into the stop has energy without a source.
  template <Scene S>
  static bool stop_changes([[maybe_unused]] const Scratch<S>& w) noexcept {
    if constexpr (uses<typename S::Joints>) return w.tree.stop_changes;
    return false;
  }

  /// True if the end of this step is a valid K_0 for the next. False after a stop reversed a coordinate
  /// within the stage, net iterations were cut off, or springs were majorised.
  template <Scene S>
  static bool is_acceleration_valid(const Scratch<S>& w) noexcept {
    bool acceleration_valid = true;
    if constexpr (uses<typename S::Joints>) acceleration_valid = !w.tree.is_stiff && !stop_changes(w);
    if constexpr (uses<ContactsOf<S>>)
      acceleration_valid = acceleration_valid && have_same_active_contacts(w.contacts.memories);
    if constexpr (uses<NetOf<S>>)
      acceleration_valid = acceleration_valid && !w.contacts.net.report.majorised &&
                           w.contacts.net.is_solved && have_same_active_contacts(w.contacts.net.memories);
    return acceleration_valid;
  }

  template <Scene S>
  static Begin first_acceleration(const Params<S>& par, const State<S>& x, const Scratch<S>& w) noexcept {
    bool smooth = true, known = true;
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      const BodyState<S>& y = x.bodies[i];
      const Real h_sq = par.h * par.h;
      smooth = smooth && (y.memory.known || x.tick == 0) && turn_is_small<S>(par.bodies[i], y.x.w_B, par.h) &&
               h_sq * h_sq * y.memory.alpha_B.squaredNorm() <= max_swing * max_swing;
      known = known && y.memory.known;
      if constexpr (uses<typename S::Device>) known = known && !w.coupling_inputs[i].fresh;
    }
    if (smooth && known) return Begin::from_memory;
    return smooth && may_start_without_acceleration(par, x) ? Begin::without_acceleration
                                                            : Begin::two_euler_stages;
  }

  /// True if a step may start without K_0. No stage overshoots the coupling's target if d h (g + d h k) <= m
  /// and (d h)^2 k_r <= I + d h g_r. A fast spin does not gain energy in its first step if h |w| sqrt(I_max /
  /// I_min) <= 1/2.
  template <Scene S>
  static bool may_start_without_acceleration(const Params<S>& par, const State<S>& x) noexcept {
    bool may = starts_without_acceleration<S>;
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      const RigidBodyParams& body = par.bodies[i].body;
      may = may && par.h * body.anisotropy * x.bodies[i].x.w_B.norm() <= max_swing;
      if constexpr (uses<typename S::Coupling>) {
        const SpringParams& spring = par.bodies[i].coupling;
        may = may && d * par.h * (spring.g + d * par.h * spring.k) <= body.m;
        // least moment about any axis is at least I, because anisotropy bounds the ratio; damped hard about
        // it
        const Real I = body.I_B.trace() / (3 * body.anisotropy * body.anisotropy);
        may = may && d * par.h * (d * par.h * spring.k_r - spring.g_r) <= I;
        // damping needed: without it a gain of the first step would persist
        may = may && (spring.g > 0 || !(spring.k > 0)) && (spring.g_r > 0 || !(spring.k_r > 0));
      }
    }
    return may;
  }

  template <Scene S>
  static bool turns_are_small(const Params<S>& par, const Scratch<S>& w) noexcept {
    bool small = true;
    for (std::size_t i = 0; i < num_bodies(par); ++i)
      small =
          small && turn_is_small<S>(par.bodies[i], lane(w.velocities[i / lanes<S>].w_B, i % lanes<S>), par.h);
    return small;
  }
};

}  // namespace godobject
