// Turns of joints are counted: stops near, across and beyond half a turn are stops (19) like all others.
#include <iostream>

#include "tests/core/joint/grasper_tool.h"
#include "tests/core/joint/usual_scene.h"

namespace godobject::test_turns {
namespace {

using WithStops = TreeJoints<JointStops>;
constexpr Real no_stop = std::numeric_limits<Real>::infinity();

TEST(Turns, AnglesAreUnwrappedByWholeTurns) {
  for (const Real angle : {-3.1, -0.2, 0.0, 1.0, 3.14})
    for (int turns = -20; turns <= 20; ++turns)
      for (const Real off : {-3.1, 0.0, 3.1})
        EXPECT_NEAR(unwrapped(angle, angle + 2 * pi * turns + off), angle + 2 * pi * turns, 1e-13);
  for (const Real angle : {-pi, -0.2, 1.0, pi}) EXPECT_EQ(unwrapped(angle, 0), angle);
}

TEST(Turns, JointsStartBetweenTheirStops) {
  const auto start = [](Real lower, Real upper, Real angle) {
    return start_coordinate({.lower = lower, .upper = upper, .k = 1, .width = 0.02}, angle);
  };
  EXPECT_EQ(start(-no_stop, no_stop, -2), -2);
  EXPECT_EQ(start(-0.5, 6, 1), 1);
  EXPECT_NEAR(start(-0.5, 6, 4 - 2 * pi), 4, 1e-15);
  EXPECT_NEAR(start(20, 25, 22 - 8 * pi), 22, 1e-14);
  EXPECT_NEAR(start(-0.5, no_stop, 4 - 2 * pi), 4, 1e-15);
  EXPECT_EQ(start(-7, 0, 1e-16), 1e-16);   // rounding is no turn
  EXPECT_EQ(start(-no_stop, -0.1, 0), 0);  // pressed at the start
  EXPECT_EQ(start(-0.3, 0.5, 0.8), 0.8);
  EXPECT_EQ(start(-no_stop, 10, -2), -2);
}

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

/// A scene of a bar whose bodies may touch: its joints are solved with its contacts.
template <class I>
struct Touching {
  static constexpr std::size_t max_bodies = 2;
  using Integrator = I;
  using Device = PoseDevice;
  using Joints = WithStops;
  using Coupling = DampedSpring;
  using Feedback = None;
  using Contacts = BodyContacts<4, 1, 4>;
};

/// A bar on one joint, its centre a lever beside it.
template <class S_>
class Bar : public Running<S_> {
 public:
  using S = S_;

  Bar(const Turn& turn, Real h, Real lever = 0.1) : turn_(turn), lever_(lever) {
    this->par.h = h;
    this->par.bodies[0].joint.kind = turn.kind;
    this->par.bodies[0].joint.C.p = Vec3(-lever, 0, 0);
    this->par.bodies[0].body = rigid_body(0.5, Vec3(1e-3, 2e-3, 3e-3).asDiagonal());
  }
  StopParams& stop() { return this->par.bodies[0].joint.stop.stops[static_cast<std::size_t>(turn_.c)]; }
  Real q() const { return this->x.bodies[0].joint.q[turn_.c]; }
  Real inertia() const {
    const RigidBodyParams& body = this->par.bodies[0].body;
    return turn_.axis.dot(body.I_B * turn_.axis) +
           body.m * Vec3(lever_, 0, 0).cross(turn_.axis).squaredNorm();
  }
  Pose turned_by(Real angle) const {
    const Quat q(Eigen::AngleAxis<Real>(angle, turn_.axis));
    return {.p = q * Vec3(lever_, 0, 0), .q = q};
  }
  /// Starts it at an angle, turning.
  void start(Real angle, Real rate) {
    const Pose X = turned_by(angle);
    const Vec3 w_W = rate * turn_.axis;
    place<S>(this->x, 0, {.X_WB = X, .V_WB = {.w = w_W, .v = w_W.cross(X.p)}});
    engage_at<S>(this->x, 0, {.X_WD = X, .V_WD = {}});
    this->in.devices[0].target.X_WD = this->x.bodies[0].x.X_WB;
    start_turns(this->par, this->x);
  }

 private:
  Turn turn_;
  Real lever_;
};

template <class I>
class CountedTurns : public ::testing::Test {};
TYPED_TEST_SUITE(CountedTurns, BothIntegrators);

/// Counted from where it starts, to either side, up to half a turn a step.
TYPED_TEST(CountedTurns, GoOnWithoutEnd) {
  for (const Turn& turn : all_turns)
    for (const Real rate : {7.0, -50.0, 600.0, -3100.0}) {
      Bar<Articulated<TypeParam, WithStops>> bar(turn, 1e-3, 0);
      bar.start(0.4, rate);
      bar.step(1500);
      ASSERT_FALSE(any(bar.out.fault));
      EXPECT_NEAR(bar.q(), 0.4 + 1.5 * rate, 1e-9 * std::abs(rate))
          << static_cast<int>(turn.kind) << ' ' << turn.c;
    }
}

/// A state a whole turn away is another one.
TYPED_TEST(CountedTurns, AreInTheHash) {
  for (const Turn& turn : all_turns) {
    Bar<Articulated<TypeParam, WithStops>> bar(turn, 1e-3);
    bar.start(0.4, 1);
    bar.step(10);
    const std::uint64_t hash = bar.hash();
    for (const int turns : {-2, -1, 1, 2}) {
      auto other = bar;
      other.x.bodies[0].joint.q[turn.c] += 2 * pi * turns;
      EXPECT_NE(other.hash(), hash);
    }
  }
}

/// A bar thrown at a stop.
struct Throw {
  Real h, k, g, width, gap, rate, side;
};
struct Bounce {
  Real depth = 0;    // rad, deepest
  Real highest = 0;  // kinetic energy, of the first
  Real bound = 0;    // of the depth: spring, width, and a step
  bool back = false;
};

template <class S>
Bounce thrown_at(const Turn& turn, const Throw& t, Real end) {
  Bar<S> bar(turn, t.h);
  bar.stop() = {.lower = t.side > 0 ? end - 5 : end,
                .upper = t.side > 0 ? end : end + 5,
                .k = t.k,
                .g = t.g,
                .width = t.width};
  bar.start(end - t.side * std::min(t.gap * t.h * t.rate, Real(2)), t.side * t.rate);
  const Real first = kinetic_energy(bar.par, bar.x);
  const Real w = std::sqrt(t.k / bar.inertia());
  Bounce b{.bound = t.rate / w + t.width + t.h * t.rate};
  const int most = static_cast<int>(std::min(20 * (1 / w + t.width / t.rate) / t.h, 10000.0)) + 100;
  for (int n = 0; n < most && !b.back; ++n) {
    bar.step();
    EXPECT_FALSE(any(bar.out.fault));
    const Real beyond = t.side * (bar.q() - end);
    b.depth = std::max(b.depth, beyond);
    b.highest = std::max(b.highest, kinetic_energy(bar.par, bar.x) / first);
    b.back = b.depth > 0 && beyond < 0;
  }
  return b;
}

/// Stops soft and stiff, narrow and wide, anywhere. As deep as the same stop at zero, never passed, and left
/// with at most the energy of the approach.
template <class S>
void expect_stops_anywhere(unsigned seed, int draws) {
  Random random(seed);
  Real gain = 0, depth = 0, difference = 0;
  int turned_back = 0;
  for (int draw = 0; draw < draws; ++draw) {
    const Turn& turn = all_turns[static_cast<std::size_t>(draw % 4)];
    const Throw t{.h = random.log_uniform(1e-4, 5e-3),
                  .k = random.log_uniform(1, 1e8),
                  .g = random.integer(0, 1) * random.uniform(0, 1),
                  .width = random.log_uniform(1e-4, 0.5),
                  .gap = random.log_uniform(0.1, 30),  // steps
                  .rate = random.log_uniform(0.1, 90),
                  .side = random.integer(0, 1) == 0 ? Real(-1) : Real(1)};
    const Real end = random.integer(0, 2) == 0 ? random.uniform(-30, 30) : pi * random.integer(-3, 3);
    SCOPED_TRACE(testing::Message() << "draw " << draw << " kind " << static_cast<int>(turn.kind) << ' '
                                    << turn.c << " h " << t.h << " k " << t.k << " g " << t.g << " width "
                                    << t.width << " rate " << t.rate << " side " << t.side << " end " << end);
    const Bounce near = thrown_at<S>(turn, t, 0), far = thrown_at<S>(turn, t, end);
    gain = std::max(gain, far.highest - 1);
    depth = std::max(depth, far.depth / far.bound);
    difference = std::max(difference, std::abs(far.depth - near.depth) / near.bound);
    EXPECT_LT(far.highest, 1 + 1e-9);
    EXPECT_LT(far.depth, far.bound);
    EXPECT_NEAR(far.depth, near.depth, 1e-7 * near.bound);
    EXPECT_EQ(far.back, near.back);
    turned_back += far.back;
  }
  std::cout << S::Integrator::name << ": energy gained " << gain << ", depth " << depth
            << " of its bound, far from near stops by " << difference << " of it, " << turned_back
            << " turned back\n";
  EXPECT_GT(turned_back, 0.9 * draws);
}

TYPED_TEST(CountedTurns, StopsAreTheSameAnywhere) {
  expect_stops_anywhere<Articulated<TypeParam, WithStops>>(5, 200);
}
TYPED_TEST(CountedTurns, StopsOfBodiesThatMayTouchAreTheSameAnywhere) {
  expect_stops_anywhere<Touching<TypeParam>>(6, 100);
}

/// A target turns slowly beyond a stop, and less than half a turn from where it holds the bar. Both springs
/// balance, k_r (over - d) = k (d - width / 2), or k d^2 / (2 width) within it.
TYPED_TEST(CountedTurns, StopHoldsAgainstACouplingAnywhere) {
  Random random(7);
  for (int draw = 0; draw < 24; ++draw) {
    const Turn& turn = all_turns[static_cast<std::size_t>(draw % 4)];
    const Real k = random.log_uniform(20, 1e4), k_r = 5, width = 0.02, over = random.uniform(0.5, 2);
    const Real side = random.integer(0, 1) == 0 ? -1 : 1;
    const Real end = side * (random.integer(0, 1) == 0 ? random.uniform(1, 20) : pi * random.integer(1, 3));
    Bar<Articulated<TypeParam, WithStops>> bar(turn, 1e-3, 0);
    bar.stop() = {.lower = -std::abs(end), .upper = std::abs(end), .k = k, .g = 0.01, .width = width};
    bar.par.bodies[0].coupling = {.k = 1000, .g = 10, .k_r = k_r, .g_r = 0.3};
    bar.start(0, 0);
    Real highest = 0;
    for (int n = 1; n <= 6000; ++n) {
      bar.in.devices[0].target.X_WD = bar.turned_by((end + side * over) * std::min(n / 5000.0, 1.0));
      bar.step();
      ASSERT_FALSE(any(bar.out.fault));
      highest = std::max(highest, bar.body().w_B.norm());
    }
    Real d = (k_r * over + k * width / 2) / (k + k_r);
    if (d < width) d = (std::sqrt(k_r * k_r + 2 * k / width * k_r * over) - k_r) * width / k;
    EXPECT_NEAR(bar.q(), end + side * d, 1e-4) << "end " << end << " k " << k << " over " << over;
    EXPECT_LT(highest, 2 * (std::abs(end) + over) / 5 + 1);
  }
}

}  // namespace
}  // namespace godobject::test_turns
