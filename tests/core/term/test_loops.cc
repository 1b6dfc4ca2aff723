// Joints that close loops (62): four-bars against their equation of one coordinate, Bricard's linkage, and
// drawn mechanisms.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

#include "tests/core/term/mechanism.h"

namespace godobject::test_loops {
namespace {

constexpr Real a = 0.05, b = 0.12, c = 0.1, d = 0.13;  // crank, coupler, rocker, ground, m
constexpr Real density = 2;                            // of rods, kg/m
constexpr Real start_angle = 0.9, gravity = 9.81, T = 0.4;
Real mass(Real length) { return density * length; }
Real inertia(Real length) { return mass(length) * length * length / 12; }

struct FourBarAt {
  Vec3 A, B;                // ends of crank and rocker
  std::array<Vec3, 3> mid;  // centres of crank, coupler, rocker
  std::array<Real, 3> angle;
};
FourBarAt four_bar_at(Real theta) {
  FourBarAt at;
  at.A = a * Vec3(std::cos(theta), std::sin(theta), 0);
  const Vec3 O(d, 0, 0), to = O - at.A;
  const Real l = to.norm(), along = (l * l + b * b - c * c) / (2 * l), up = std::sqrt(b * b - along * along);
  const Vec3 u = to / l;
  at.B = at.A + along * u + up * Vec3(-u.y(), u.x(), 0);
  at.mid = {Vec3(at.A / 2), Vec3((at.A + at.B) / 2), Vec3((O + at.B) / 2)};
  at.angle = {theta, std::atan2(at.B.y() - at.A.y(), at.B.x() - at.A.x()),
              std::atan2(at.B.y() - O.y(), at.B.x() - O.x())};
  return at;
}
/// Returns the rates of crank, coupler and rocker by that of the crank.
std::array<Real, 3> rates(const FourBarAt& at) {
  const auto across = [](Real length, Real angle) {
    return Eigen::Vector2d(-length * std::sin(angle), length * std::cos(angle));
  };
  Eigen::Matrix2d A;  // crank + coupler = rocker
  A << -across(b, at.angle[1]), across(c, at.angle[2]);
  const Eigen::Vector2d rate = A.inverse() * across(a, at.angle[0]);
  return {1, rate[0], rate[1]};
}
/// Returns the effective inertia M(theta) of the whole.
Real effective_inertia(Real theta) {
  const FourBarAt at = four_bar_at(theta);
  const std::array<Real, 3> rate = rates(at);
  const Vec3 v_A(-at.A.y(), at.A.x(), 0), half = (at.B - at.A) / 2;
  const Real v_sq = (v_A + rate[1] * Vec3(-half.y(), half.x(), 0)).squaredNorm();
  return mass(a) * a * a / 3 + mass(c) * c * c / 3 * rate[2] * rate[2] + mass(b) * v_sq +
         inertia(b) * rate[1] * rate[1];
}
/// Returns the potential V(theta).
Real potential(Real theta) {
  const FourBarAt at = four_bar_at(theta);
  const std::array length{a, b, c};
  Real V = 0;
  for (std::size_t i = 0; i < 3; ++i) V += mass(length[i]) * gravity * at.mid[i].y();
  return V;
}
/// Returns the crank's angle at time t.
Real exact_angle(Real t) { return coordinate_at(t, effective_inertia, potential, start_angle); }

/// A four-bar of rods in gravity, turned by q_W as a whole. kind: of the closing joint. angle: of the
/// crank.
template <class I>
std::unique_ptr<Mechanism<I>> four_bar(Real h, JointKind kind, const Quat& q_W = Quat::Identity(),
                                       Real angle = start_angle) {
  auto run = std::make_unique<Mechanism<I>>();
  run->par.num_bodies = 0;
  run->par.h = h;
  run->par.gravity_W = q_W * Vec3(0, -gravity, 0);
  const FourBarAt at = four_bar_at(angle);
  const auto turned = [&](const Pose& X) { return Pose{.p = q_W * X.p, .q = q_W * X.q}; };
  const auto link = [&](Real length, const Vec3& p, const Vec3& q, std::size_t parent, const Vec3& joint) {
    const Real I_l = inertia(length);
    return add_link(*run, mass(length), Mat3(Vec3(0.01 * I_l, I_l, I_l).asDiagonal()), turned(rod(p, q)),
                    JointKind::hinge, parent, turned({.p = joint, .q = Quat::Identity()}));
  };
  const Vec3 O(d, 0, 0);
  const std::uint32_t crank = link(a, Vec3::Zero(), at.A, world, Vec3::Zero());
  const std::uint32_t coupler = link(b, at.A, at.B, crank, at.A);
  const std::uint32_t rocker = link(c, O, at.B, world, O);
  close_loop(*run, kind, coupler, rocker, turned({.p = at.B, .q = Quat::Identity()}));
  EXPECT_EQ(validate(run->par), Invalid::nothing);
  start_turns(run->par, run->x);
  return run;
}

struct LoopError {
  Real angle = 0, apart = 0, gained = 0;
};
template <class I>
LoopError error(Real h, JointKind kind, const Quat& q_W, Real exact) {
  const auto run = four_bar<I>(h, kind, q_W);
  EnergyBalance<Looped<I>> balance;
  balance.start(run->par, run->x);
  LoopError worst;
  for (long n = 0; n < std::lround(T / h); ++n) {
    run->step();
    EXPECT_EQ(run->out.fault, Fault::none);
    balance.observe(run->par, run->x, run->w, run->out);
    EXPECT_FALSE(balance.gains());
    worst.apart = std::max(worst.apart, apart(*run));
  }
  worst.angle = std::abs(start_angle + run->x.bodies[0].joint.q[0] - exact);
  return worst;
}

TEST(Loops, FourBarTurnsAsItsOneEquationSays) {
  const Real exact = exact_angle(T);
  for (const JointKind kind : {JointKind::hinge, JointKind::ball, JointKind::cylindrical}) {
    const Quat q_W = exp_so3(Vec3(kind == JointKind::hinge ? 0 : 1, 1.1, -0.6));
    const auto check = [&]<class I>(I, Real least_order, Real most) {
      const LoopError e_1 = error<I>(4e-3, kind, q_W, exact), e_2 = error<I>(2e-3, kind, q_W, exact),
                      e_3 = error<I>(1e-3, kind, q_W, exact);
      std::printf("%s, joint %d: %.1e, %.1e, %.1e rad, order %.2f; apart by %.1e, %.1e m\n", I::name,
                  static_cast<int>(kind), e_1.angle, e_2.angle, e_3.angle, std::log2(e_2.angle / e_3.angle),
                  e_1.apart, e_3.apart);
      EXPECT_GT(std::log2(e_2.angle / e_3.angle), least_order) << I::name;
      EXPECT_LT(e_3.angle, most) << I::name;
      EXPECT_LT(e_1.apart, 1e-5) << I::name;
    };
    check(ImplicitEuler{}, 0.8, 1);
    check(TrBdf2{}, 1.9, 5e-5);
  }
}

/// Weight of a closed square at rest: the closing joint bears the force that statics gives.
TEST(Loops, ClosingJointBearsTheWeight) {
  const auto bears = [&]<class I>(I) {
    // a beam of 1 kg on two posts of the world, hinged to one and closed by a ball to the other
    auto run = std::make_unique<Mechanism<I>>();
    run->par.num_bodies = 0;
    run->par.h = 1e-3;
    run->par.gravity_W = Vec3(0, 0, -9.81);
    const Pose X_WB{};
    add_link(*run, 1, Mat3(Vec3(1e-3, 1e-2, 1e-2).asDiagonal()), X_WB, JointKind::hinge, world,
             {.p = Vec3(-0.2, 0, 0), .q = exp_so3(Vec3(pi / 2, 0, 0))});
    close_loop(*run, JointKind::ball, TermEnds::on_world, 0, {.p = Vec3(0.3, 0, 0), .q = Quat::Identity()});
    run->step(200);
    const Vec3 F = run->out.terms.list[0].f;
    EXPECT_NEAR(F.z(), 9.81 * 0.2 / 0.5, 1e-6) << I::name;
    EXPECT_LT(run->x.bodies[0].x.v_W.norm(), 1e-9) << I::name;
    EXPECT_LT(apart(*run), 1e-9) << I::name;
  };
  bears(ImplicitEuler{});
  bears(TrBdf2{});
}

/// A universal joint locks a four-bar, whose crank is almost in line with the coupler. The joint hardly moves
/// the crank, and bears a multiple of its load. A spring loads the crank at once. Afterwards nothing moves,
/// so that no energy returns.
TEST(Loops, LockedOnesNearASingularPoseGainNoEnergy) {
  const Real in_line = std::acos(((a + b) * (a + b) + d * d - c * c) / (2 * (a + b) * d));
  const auto gain = [&]<class I>(I, Real off_line) {
    const auto run =
        four_bar<I>(1e-3, JointKind::universal, exp_so3(Vec3(0.4, 1.1, -0.6)), in_line + off_line);
    const RigidBodyState& crank = run->x.bodies[0].x;
    const Vec3 end = crank.X_WB.p + to_world(crank.X_WB.q, Vec3(a / 2, 0, 0));
    const Vec3 across = to_world(crank.X_WB.q, Vec3::UnitY());
    auto& springs = run->par.terms.template of<1>();
    springs.list[springs.size++] = {
        .a = {.p = end + 0.01 * across}, .b = {.on = 0, .p = Vec3(a / 2, 0, 0)}, .k = 1e6};
    EXPECT_EQ(validate(run->par), Invalid::nothing);
    EnergyBalance<Looped<I>> balance;
    balance.start(run->par, run->x);
    Real least = balance.balance(), most_gained = 0;
    const Real at_work = balance.energy();
    for (int n = 0; n < 500; ++n) {
      run->step();
      EXPECT_EQ(run->out.fault, Fault::none);
      balance.observe(run->par, run->x, run->w, run->out);
      least = std::min(least, balance.balance());
      most_gained = std::max(most_gained, balance.balance() - least);
    }
    std::printf("%s, %.0e rad: gains %.1e of the energy\n", I::name, off_line, most_gained / at_work);
    return most_gained / at_work;
  };
  for (const Real off_line : {3e-2, 1e-2, 3e-3, 1e-3}) {
    EXPECT_LT(gain(ImplicitEuler{}, off_line), 1e-5);
    EXPECT_LT(gain(TrBdf2{}, off_line), 1e-5);
  }
}

/// Bricard's linkage: five rods of 1 m and six hinges, of one freedom though counted as none. It falls
/// through its plane positions and its energy is kept (the IFToMM benchmark, 0 to 10 s).
template <class I>
std::unique_ptr<Mechanism<I>> bricard(Real h) {
  auto run = std::make_unique<Mechanism<I>>();
  run->par.num_bodies = 0;
  run->par.h = h;
  run->par.gravity_W = Vec3(0, -9.81, 0);
  const std::array<Vec3, 6> p{Vec3(0, 0, 0),  Vec3(1, 0, 0),  Vec3(1, -1, 0),
                              Vec3(1, -1, 1), Vec3(0, -1, 1), Vec3(0, 0, 1)};
  const std::array<Vec3, 6> axis{Vec3::UnitY(), Vec3::UnitZ(), Vec3::UnitX(),
                                 Vec3::UnitY(), Vec3::UnitZ(), Vec3::UnitX()};
  std::size_t parent = world;
  for (std::size_t i = 0; i < 5; ++i) {
    const Real m = 1, I_l = m / 12;
    parent = add_link(*run, m, Mat3(Vec3(1e-3 * I_l, I_l, I_l).asDiagonal()), rod(p[i], p[i + 1]),
                      JointKind::hinge, parent, {.p = p[i], .q = turn_from_z(axis[i])});
  }
  close_loop(*run, JointKind::hinge, TermEnds::on_world, 4, {.p = p[5], .q = turn_from_z(axis[5])});
  EXPECT_EQ(validate(run->par), Invalid::nothing);
  start_turns(run->par, run->x);
  return run;
}
TEST(Loops, BricardKeepsItsEnergy) {
  const auto run_for = [&]<class I>(I, Real h, Real most_lost) {
    const auto run = bricard<I>(h);
    EnergyBalance<Looped<I>> balance;
    balance.start(run->par, run->x);
    const Real E_0 = balance.energy();
    Real low = 0, farthest = 0, most = 0;
    for (long n = 0; n < std::lround(10 / h); ++n) {
      run->step();
      ASSERT_EQ(run->out.fault, Fault::none);
      balance.observe(run->par, run->x, run->w, run->out);
      ASSERT_FALSE(balance.gains()) << I::name << " at step " << n;
      low = std::min(low, run->x.bodies[2].x.X_WB.p.y());
      farthest = std::max(farthest, apart(*run));
      most = std::max(most, std::abs(balance.energy() - E_0));
    }
    std::printf("%s: Bricard, energy within %.1e J, apart by %.1e m, lowest point %.3f m\n", I::name, most,
                farthest, low);
    EXPECT_LT(most, most_lost) << I::name;
    EXPECT_LT(farthest, 1e-5) << I::name;
    EXPECT_LT(low, -1.2) << "it moves";
  };
  run_for(TrBdf2{}, 1e-3, 1e-2);
  run_for(ImplicitEuler{}, 1e-3, 20);
}

/// Spheres at the closing joint overlap; only without the joint they touch.
TEST(Loops, BodiesOfALoopDoNotTouchEachOther) {
  const auto contacts = [](bool closed) {
    auto run = four_bar<TrBdf2>(1e-3, JointKind::hinge);
    auto& loops = run->par.terms.template of<0>();
    add_sphere(run->par, 1, loops.list[0].P.p, 0.01);
    add_sphere(run->par, 2, loops.list[0].C.p, 0.01);
    set_law(run->par, {.k = 1e4, .c = 1});
    if (!closed) loops.size = 0;
    EXPECT_EQ(validate(run->par), Invalid::nothing);
    std::size_t most = 0;
    for (int n = 0; n < 50; ++n) {
      run->step();
      most = std::max<std::size_t>(most, run->out.contacts.num_contacts);
    }
    return most;
  };
  EXPECT_EQ(contacts(true), 0u);
  EXPECT_GT(contacts(false), 0u);
}

TEST(Loops, AreChecked) {
  const auto validated = [](auto change) {
    auto run = four_bar<TrBdf2>(1e-3, JointKind::hinge);
    change(run->par.terms.template of<0>().list[0]);
    return validate(run->par);
  };
  EXPECT_EQ(validated([](LoopJointParams&) {}), Invalid::nothing);
  EXPECT_EQ(validated([](LoopJointParams& p) { p.kind = JointKind::free; }), Invalid::term);
  EXPECT_EQ(validated([](LoopJointParams& p) { p.b = p.a; }), Invalid::term);
  EXPECT_EQ(validated([](LoopJointParams& p) { p.b = 9; }), Invalid::term);
  EXPECT_EQ(validated([](LoopJointParams& p) { p.C.R *= 2; }), Invalid::term);
}

}  // namespace
}  // namespace godobject::test_loops
