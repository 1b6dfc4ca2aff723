// Targets of bodies on joints are counted as the joints' coordinates are (16). A target turned beyond a stop by
// any number of turns presses the body on it, and brings it back only with its own motion.
#include <iostream>

#include "tests/core/joint/grasper_tool.h"

namespace godobject::test_wound_targets {
namespace {

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
const std::array<Turn, 4> all_turns{{{JointKind::hinge, 0, Vec3::UnitZ()},
                                     {JointKind::cylindrical, 0, Vec3::UnitZ()},
                                     {JointKind::universal, 0, Vec3::UnitX()},
                                     {JointKind::universal, 1, Vec3::UnitY()}}};

constexpr Real unlimited = 1e12;

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

struct Worst {
  Real depth = 0, torque = 0, shown = 0, rest = 0, back = 0;
  int rests = 0, chatters = 0;
};

template <class S>
void expect_held(unsigned seed, int draws) {
  Random random(seed);
  Worst worst;
  for (int draw = 0; draw < draws; ++draw) {
    const Winding t = Winding::random(random);
    // chatter shakes the other axis of a universal joint
    const Turn& turn = all_turns[static_cast<std::size_t>(t.is_stiff ? draw % 2 : draw % 4)];
    SCOPED_TRACE(testing::Message() << "draw " << draw << ' ' << t);
    auto run = std::make_unique<Wound<S>>();
    run->par.h = t.h;
    run->q_WS = random.rotation();
    run->add(0, turn, t.inertia, t.k_r, t.zeta);
    run->stop(0) = t.stop();
    run->start();
    const Real side = t.end > 0 ? 1 : -1;
    const Real g_r = run->par.bodies[0].coupling.g_r;
    const Real I = turn.axis.dot(run->par.bodies[0].body.I_B * turn.axis);
    // Statics at the largest torque, of spring and damper. The depth of arriving at the target's speed. The way
    // of a step from rest under that torque, without the stop.
    const Real largest = t.k_r * std::abs(t.over) + g_r * std::abs(t.rate);
    const Real inertia = I + t.h * g_r + t.h * t.h * t.k_r;
    const Real bound = t.depth(largest) + std::abs(t.rate) * (std::sqrt(I / t.k) + t.h) + t.width +
                       t.h * t.h * largest / inertia;
    const auto follow = [&](Real rate) {
      run->follow({rate, 0});
      const Real e = run->target[0] - run->q(0);
      worst.depth = std::max(worst.depth, side * (run->q(0) - t.end) / bound);
      worst.torque = std::max(worst.torque, std::abs(run->spring_torque(0).dot(turn.axis) / t.k_r - e));
      worst.shown = std::max(worst.shown, std::abs(run->shown_torque(0).dot(turn.axis) / t.k_r + e));
    };
    for (int n = 0; n < t.steps(); ++n) follow(t.rate);
    for (int n = 0; n < t.steps_at_rest(); ++n) follow(0);
    const Real force = t.k_r * (run->target[0] - run->q(0));
    const Real d = side * (run->q(0) - t.end);
    const Real s = std::min(d, t.width);
    const Real off = std::abs(t.k * s * (d - s / 2) / t.width - side * force) / std::abs(force);
    if (!t.is_stiff) worst.rest = std::max(worst.rest, off), ++worst.rests;
    else worst.chatters += off > 1e-6;
    for (int n = 0; n < t.steps(); ++n) follow(-t.rate);
    for (int n = 0; n < t.steps_at_rest(); ++n) follow(0);
    worst.back = std::max(worst.back, std::abs(run->q(0) - run->target[0]));
    EXPECT_FALSE(run->balance.gains());
    ASSERT_LT(worst.depth, 1);
    ASSERT_LT(worst.torque, 1e-7);
    ASSERT_LT(worst.shown, 1e-7);
    ASSERT_LT(worst.rest, 1e-6);
    ASSERT_LT(worst.back, 1e-3);
  }
  std::cout << S::Integrator::name << ": depth " << worst.depth << " of its bound, spring torque / k_r off "
            << worst.torque << " rad, displayed " << worst.shown << " rad, at rest " << worst.rest
            << " of it (" << worst.rests << " of " << draws << "; " << worst.chatters
            << " stiff ones chatter), back to " << worst.back << " rad\n";
}

template <class I>
class WoundTargets : public ::testing::Test {};
TYPED_TEST_SUITE(WoundTargets, BothIntegrators);

TYPED_TEST(WoundTargets, PressOnTheStopOfASingleBody) { expect_held<Tool<TypeParam, 1>>(1, 60); }
TYPED_TEST(WoundTargets, PressOnTheStopOfABodyInAPack) { expect_held<Tool<TypeParam, 3>>(2, 60); }
TYPED_TEST(WoundTargets, PressOnTheStopOfABodyThatMayTouch) { expect_held<TouchingTool<TypeParam>>(3, 24); }

}  // namespace
}  // namespace godobject::test_wound_targets
