// Links on joints that turn, and targets that turn beyond their stops and back.
#pragma once

#include <memory>

#include "tests/core/joint/grasper_tool.h"

namespace godobject::test_wound {

using WithStops = TreeJoints<JointStops>;

/// A scene of N bodies on joints with stops. Numbers of up to two bodies are single, others in packs.
template <class I, std::size_t N>
struct Tool {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = PoseDevice;
  using Joints = WithStops;
  using Coupling = DampedSpring;
  using Feedback = LimitedFeedback;
};
/// A tool whose bodies may touch.
template <class I>
struct TouchingTool : Tool<I, 2> {
  using Contacts = BodyContacts<4, 1, 4>;
};

/// A coordinate that turns, of a kind of joint.
struct Turn {
  JointKind kind;
  int c;
  Vec3 axis;
};
inline const std::array<Turn, 4> all_turns{{{JointKind::hinge, 0, Vec3::UnitZ()},
                                            {JointKind::cylindrical, 0, Vec3::UnitZ()},
                                            {JointKind::universal, 0, Vec3::UnitX()},
                                            {JointKind::universal, 1, Vec3::UnitY()}}};

inline constexpr Real unlimited = 1e12;

/// Links on joints that turn, each with a target, in a scene that is turned as a whole by q_WS.
template <class S_>
struct Wound : Running<S_> {
  using S = S_;

  std::size_t size = 1;
  Quat q_WS = Quat::Identity();
  std::array<Real, 2> target{};  // coordinates of the targets of both links
  std::array<Turn, 2> turn{all_turns[0], all_turns[0]};
  Mat3 R_2 = Mat3::Identity();  // frame of the second joint on the first link
  EnergyBalance<S> balance;

  void add(std::size_t i, const Turn& t, Real inertia, Real k_r, Real zeta) {
    turn[i] = t;
    size = this->par.num_bodies = i + 1;
    auto& body = this->par.bodies[i];
    body.joint.kind = t.kind;
    body.joint.parent = i == 0 ? world : 0;
    body.joint.P.R = i == 0 ? Mat3(q_WS.toRotationMatrix()) : R_2;
    body.body = rigid_body(0.05, inertia * Vec3(1, 1.2, 0.8).asDiagonal());
    body.coupling = spring(body.body, 1000, k_r, zeta);
    body.feedback = {.gains = body.coupling,
                     .max_force = unlimited,
                     .max_torque = unlimited,
                     .max_force_rate = unlimited,
                     .max_torque_rate = unlimited};
    body.device = {.rise = 0, .lost = 0.02};
  }
  StopParams& stop(std::size_t i) {
    return this->par.bodies[i].joint.stop.stops[static_cast<std::size_t>(turn[i].c)];
  }
  Real q(std::size_t i) const { return this->x.bodies[i].joint.q[turn[i].c]; }
  /// Returns the attitude of link i with the joints at these coordinates.
  Quat attitude(std::size_t i, const std::array<Real, 2>& at) const {
    const Quat first = q_WS * Quat(Eigen::AngleAxis<Real>(at[0], turn[0].axis));
    if (i == 0) return first;
    const Eigen::Quaternion<Real> q(R_2);
    return first * Quat(q.w(), q.x(), q.y(), q.z()) * Quat(Eigen::AngleAxis<Real>(at[1], turn[1].axis));
  }
  void aim() {
    for (std::size_t i = 0; i < size; ++i) this->in.devices[i].target.X_WD.q = attitude(i, target);
  }
  void start(const std::array<Real, 2>& at = {}) {
    target = at;
    aim();
    for (std::size_t i = 0; i < size; ++i) {
      place<S>(this->x, i, {.X_WB = {.p = Vec3::Zero(), .q = attitude(i, at)}, .V_WB = {}});
      engage_at<S>(this->x, i, {.X_WD = this->in.devices[i].target.X_WD, .V_WD = {}});
    }
    start_turns(this->par, this->x);
    balance.start(this->par, this->x);
  }
  /// Steps towards targets that turn at these rates meanwhile.
  void follow(const std::array<Real, 2>& rate) {
    for (std::size_t i = 0; i < size; ++i) target[i] += this->par.h * rate[i];
    aim();
    const Vec3 w_0 = q_WS * Vec3(rate[0] * turn[0].axis);
    for (std::size_t i = 0; i < size; ++i) {
      this->in.devices[i].target.V_WD.w = w_0;
      if (i == 1) this->in.devices[1].target.V_WD.w += attitude(1, target) * Vec3(rate[1] * turn[1].axis);
    }
    this->step();
    ASSERT_FALSE(any(this->out.fault));
    balance.observe(this->par, this->x, this->w, this->out);
  }
  /// Returns the torque of the spring of link i, of the coupling without its damper, in the scene's axes.
  Vec3 spring_torque(std::size_t i) const {
    const CouplingAt at = coupling_at(this->par, this->x, i);
    const RigidBodyState& body = this->x.bodies[i].x;
    const Vec3 damped =
        at.spring.g_r * (this->x.bodies[i].device.last.V_WD.w - to_world(body.X_WB.q, body.w_B));
    return q_WS.conjugate() * Vec3(at.F_WB.tau - damped);
  }
  /// Returns the displayed torque of link i without its damper, in the scene's axes.
  Vec3 shown_torque(std::size_t i) const {
    const RigidBodyState& body = this->x.bodies[i].x;
    const SpringParams& gains = this->par.bodies[i].feedback.gains;
    const Vec3 damped = gains.g_r * (to_world(body.X_WB.q, body.w_B) - this->x.bodies[i].device.last.V_WD.w);
    return q_WS.conjugate() * Vec3(this->out.bodies[i].feedback.F_D.tau - damped);
  }
};

/// A target that turns beyond a stop, rests, and comes back to where it began.
struct Winding {
  Real h, inertia, k_r, zeta, k, g, width, end, over, rate;
  bool is_stiff;  // stop: it may chatter, because it turns the body round within a step

  static Winding random(Random& random) {
    const Real side = random.integer(0, 1) == 0 ? -1 : 1;
    Winding t{.h = random.log_uniform(2e-4, 2e-3),
              .inertia = random.log_uniform(1e-5, 1e-2),
              .k_r = random.log_uniform(0.5, 20),
              .zeta = random.uniform(0.7, 2),
              .k = random.log_uniform(100, 1e6),
              .g = random.integer(0, 1) * random.uniform(0, 0.1),
              .width = random.log_uniform(1e-3, 0.1),
              .end = side * (random.integer(0, 2) == 0 ? pi : random.uniform(0.1, 8)),
              .over = side * random.uniform(0.2, 6 * pi),
              .rate = side * random.log_uniform(3, 60),
              .is_stiff = random.integer(0, 2) == 0};
    if (!t.is_stiff) t.k = std::min(t.k, t.inertia / (t.h * t.h));
    return t;
  }
  friend std::ostream& operator<<(std::ostream& out, const Winding& t) {
    return out << "h " << t.h << " I " << t.inertia << " k_r " << t.k_r << " zeta " << t.zeta << " k " << t.k
               << " g " << t.g << " width " << t.width << " end " << t.end << " over " << t.over << " rate "
               << t.rate;
  }
  StopParams stop() const {
    return {
        .lower = end > 0 ? end - 9 : end, .upper = end > 0 ? end : end + 9, .k = k, .g = g, .width = width};
  }
  int steps() const { return static_cast<int>((end + over) / (rate * h)) + 1; }
  int steps_at_rest() const { return static_cast<int>((0.1 + 60 * std::sqrt(inertia / k_r)) / h); }
  /// Returns the depth at which the stop bears a torque.
  Real depth(Real torque) const {
    const Real whole = k * width / 2;
    return torque > whole ? width / 2 + torque / k : std::sqrt(2 * torque * width / k);
  }
};

}  // namespace godobject::test_wound
