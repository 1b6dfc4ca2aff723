// Targets of bodies on joints are counted as the joints' coordinates are (16). A target turned beyond a stop
// by any number of turns presses the body on it, and brings it back only with its own motion.
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
    // Statics at the largest torque, of spring and damper. The depth of arriving at the target's speed.
    // The way of a step from rest under that torque, without the stop.
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

/// A chain of two links. The first is wound against its stop, while the second bends about an axis at a slant
/// from the plane across that of the first.
template <class S>
void expect_chain_held(unsigned seed, int draws, Real slant) {
  Random random(seed);
  Real jump = 0, rest = 0, back = 0, depth = 0;
  for (int draw = 0; draw < draws; ++draw) {
    Winding t = Winding::random(random);
    t.is_stiff = false;
    t.k = std::min(t.k, t.inertia / (t.h * t.h));
    const Real k_r_2 = t.k_r * random.log_uniform(0.1, 1), bend = random.uniform(-1.5, 1.5);
    auto run = std::make_unique<Wound<S>>();
    run->par.h = t.h;
    run->q_WS = random.rotation();
    const Real around = random.uniform(0, 2 * pi);
    const Vec3 axis_2(std::cos(slant) * std::cos(around), std::cos(slant) * std::sin(around),
                      std::sin(slant));
    run->R_2 = turn_from_z(axis_2).toRotationMatrix();
    SCOPED_TRACE(testing::Message() << "draw " << draw << ' ' << t << " k_r_2 " << k_r_2 << " bend " << bend
                                    << " axis " << axis_2.transpose());
    run->add(0, all_turns[static_cast<std::size_t>(draw % 2)], t.inertia, t.k_r, t.zeta);
    run->add(1, all_turns[0], random.uniform(0.1, 1) * t.inertia, k_r_2, t.zeta);
    run->stop(0) = t.stop();
    run->start();
    const Real side = t.end > 0 ? 1 : -1;
    const Real all = t.k_r + k_r_2, g_r = run->par.bodies[0].coupling.g_r + run->par.bodies[1].coupling.g_r;
    const Real largest = all * std::abs(t.over) + g_r * (std::abs(t.rate) + std::abs(bend));
    const Real bound = t.depth(largest) + std::abs(t.rate) * (std::sqrt(4 * t.inertia / t.k) + t.h) +
                       t.width + t.h * t.h * largest / t.inertia;
    std::array<Vec3, 2> last{Vec3::Zero(), Vec3::Zero()};
    std::array<Real, 2> q_last{};
    const auto follow = [&](Real rate, Real rate_2) {
      run->follow({rate, rate_2});
      depth = std::max(depth, side * (run->q(0) - t.end) / bound);
      const Real moved = std::abs(run->q(0) - q_last[0]) + std::abs(run->q(1) - q_last[1]) +
                         t.h * (std::abs(rate) + std::abs(rate_2));
      for (std::size_t i = 0; i < 2; ++i) {
        const Vec3 tau = run->spring_torque(i) / run->par.bodies[i].coupling.k_r;
        jump = std::max(jump, (tau - last[i]).norm() - (2 + tau.norm()) * moved);
        last[i] = tau;
        q_last[i] = run->q(i);
      }
    };
    for (int n = 0; n < t.steps(); ++n) follow(t.rate, bend / (t.steps() * t.h));
    for (int n = 0; n < 3 * t.steps_at_rest(); ++n) follow(0, 0);
    const Real ahead = run->target[0] - run->q(0), ahead_2 = run->target[1] - run->q(1);
    if (slant == 0) rest = std::max(rest, std::abs(run->spring_torque(1).z() / (k_r_2 * ahead) - 1));
    // both turn about one axis: the second follows its target, whose turns are those of both
    if (slant == pi / 2) rest = std::max(rest, std::abs(ahead + ahead_2));
    for (int n = 0; n < t.steps(); ++n) follow(-t.rate, -bend / (t.steps() * t.h));
    for (int n = 0; n < 3 * t.steps_at_rest(); ++n) follow(0, 0);
    back = std::max({back, std::abs(run->q(0) - run->target[0]), std::abs(run->q(1) - run->target[1])});
    EXPECT_FALSE(run->balance.gains());
    ASSERT_LT(depth, 1);
    // a side that is kept beyond the half turn changes at another axis
    ASSERT_LT(jump, 2 * pi * half_turn_band);
    ASSERT_LT(rest, 1e-6);
    ASSERT_LT(back, 1e-3);
  }
  std::cout << S::Integrator::name << ", slant " << slant << ": depth " << depth
            << " of its bound, jump of the torque / k_r " << jump << " rad, at rest " << rest << ", back to "
            << back << " rad\n";
}

TYPED_TEST(WoundTargets, PressChainsAcross) {
  expect_chain_held<Tool<TypeParam, 2>>(4, 30, 0);
  expect_chain_held<Tool<TypeParam, 5>>(5, 30, 0);
}
TYPED_TEST(WoundTargets, PressChainsAlong) { expect_chain_held<Tool<TypeParam, 5>>(6, 30, pi / 2); }
TYPED_TEST(WoundTargets, PressChainsAslant) { expect_chain_held<Tool<TypeParam, 5>>(7, 30, 0.7); }

/// A tool wound by about two turns on its stop, with its scene turned by q_WS.
template <class S>
std::unique_ptr<Wound<S>> wound_tool(const Quat& q_WS = Quat::Identity()) {
  auto run = std::make_unique<Wound<S>>();
  run->q_WS = q_WS;
  run->R_2 = turn_from_z(Vec3(1, 0.5, 0.2)).toRotationMatrix();
  run->add(0, all_turns[0], 1e-3, 5, 1.4);
  run->add(1, all_turns[0], 5e-4, 2, 1.4);
  run->stop(0) = {.lower = -2.967, .upper = 2.967, .k = 200, .g = 0.01, .width = 0.02};
  run->start();
  for (int n = 0; n < 3000; ++n) run->follow({5, 0.2});
  return run;
}

/// Turning the whole scene turns all poses, and changes nothing else.
TYPED_TEST(WoundTargets, AreTheSameInATurnedScene) {
  Random random(8);
  const auto run = wound_tool<Tool<TypeParam, 5>>();
  for (int draw = 0; draw < 4; ++draw) {
    const auto turned = wound_tool<Tool<TypeParam, 5>>(random.rotation());
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_NEAR(turned->q(i), run->q(i), 1e-9);
      EXPECT_LT((turned->spring_torque(i) - run->spring_torque(i)).norm(), 1e-8);
    }
    EXPECT_NEAR(turned->balance.energy(), run->balance.energy(), 1e-8 * run->balance.energy());
  }
}

/// A device that engages again, at once or after a long gap, begins on the turn nearest to the body.
TYPED_TEST(WoundTargets, AreCountedFromEngaging) {
  for (const bool is_gap : {false, true}) {
    auto run = wound_tool<Tool<TypeParam, 2>>();
    ASSERT_NEAR(run->spring_torque(0).z() / 5, run->target[0] - run->q(0), 1e-9);
    PoseDevice::Input& in = run->in.devices[0];
    (is_gap ? in.valid : in.engaged) = false;
    for (int n = 0; n < 100; ++n) run->step();
    in.valid = in.engaged = true;
    for (int n = 0; n < 3000; ++n) run->follow({0, 0});
    const Real e = run->target[0] - run->q(0);
    EXPECT_LE(std::abs(run->spring_torque(0).z() / 5), pi) << is_gap;
    EXPECT_NEAR(unwrapped(e, run->spring_torque(0).z() / 5), run->spring_torque(0).z() / 5, 1e-9);
    EXPECT_FALSE(run->x.bodies[0].joint.ahead.any());
  }
}

/// States whose targets are a turn apart are different states.
TYPED_TEST(WoundTargets, AreInTheHash) {
  const auto run = wound_tool<Tool<TypeParam, 5>>();
  const std::uint64_t hash = run->hash();
  std::int16_t& turns = run->x.bodies[0].joint.ahead.list[0].turns;
  ASSERT_EQ(turns, 2);
  turns = 3;
  EXPECT_NE(run->hash(), hash);
}

/// A chain on a root that is free or on a ball joint. Its second link is wound on its stop while the targets
/// of the whole tool turn about any axis and back.
TYPED_TEST(WoundTargets, OfAToolThatTurnsComeBack) {
  using S = Tool<TypeParam, 5>;
  Random random(9);
  for (int draw = 0; draw < 20; ++draw) {
    auto run = std::make_unique<Running<S>>();
    auto& par = run->par;
    par.num_bodies = 3;
    for (std::size_t i = 0; i < 3; ++i) {
      auto& body = par.bodies[i];
      body.body = rigid_body(0.1, 1e-3 * Vec3(1, 1.3, 0.8).asDiagonal());
      body.coupling = spring(body.body, 1000, i == 0 ? 20 : 3);
      body.device = {.rise = 0, .lost = 0.02};
      body.joint.kind = i > 0 ? JointKind::hinge : draw % 2 == 0 ? JointKind::ball : JointKind::free;
      body.joint.parent = i == 0 ? world : i - 1;
    }
    par.bodies[1].joint.stop.stops[0] = {.lower = -2, .upper = 2, .k = 300, .g = 0.05, .width = 0.02};
    const Quat q_12 = random.rotation();
    par.bodies[2].joint.P.R = q_12.toRotationMatrix();
    const Vec3 axis = random.direction();
    const Real far = random.uniform(2, 14), turn = random.uniform(1, 7);
    const auto aim = [&](Real wound, Real turned) {
      const Quat q_0(Eigen::AngleAxis<Real>(turn * turned, axis));
      const Quat q_1 = q_0 * Quat(Eigen::AngleAxis<Real>(far * wound, Vec3::UnitZ()));
      run->in.devices[0].target.X_WD.q = q_0;
      run->in.devices[1].target.X_WD.q = q_1;
      run->in.devices[2].target.X_WD.q = q_1 * q_12;
    };
    aim(0, 0);
    for (std::size_t i = 0; i < 3; ++i) {
      const Pose& X_WD = run->in.devices[i].target.X_WD;
      place<S>(run->x, i, {.X_WB = X_WD, .V_WB = {}});
      engage_at<S>(run->x, i, {.X_WD = X_WD, .V_WD = {}});
    }
    start_turns(par, run->x);
    EnergyBalance<S> balance;
    balance.start(par, run->x);
    for (int n = 0; n < 9000; ++n) {
      const Real t = n * par.h;
      aim(std::clamp(t < 4.5 ? t / 2 : (8 - t) / 2, Real(0), Real(1)),
          std::clamp(t < 4.5 ? (t - 2) / 2 : (Real(6.5) - t) / 2, Real(0), Real(1)));
      run->step();
      balance.observe(par, run->x, run->w, run->out);
      ASSERT_FALSE(any(run->out.fault));
    }
    EXPECT_FALSE(balance.gains());
    for (std::size_t i = 1; i < 3; ++i) EXPECT_NEAR(run->x.bodies[i].joint.q[0], 0, 1e-9) << draw;
  }
}

}  // namespace
}  // namespace godobject::test_wound_targets
