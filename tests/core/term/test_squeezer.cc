// Andrews' squeezer: seven plane bodies in three closed loops, a spring and a constant torque.
//
// The solution at 0.03 s is that of the Test Set for Initial Value Problem Solvers (University of Bari). The
// equations are in Hairer and Wanner, Solving Ordinary Differential Equations II, VII.7.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

#include "tests/core/contact/contact_scene.h"

namespace godobject::test_squeezer {
namespace {

template <class I>
struct Squeezer {
  static constexpr std::size_t max_bodies = 7;
  using Integrator = I;
  using Device = None;
  using Joints = TreeJoints<JointStops>;
  using Coupling = None;
  using Feedback = None;
  using Contacts = BodyContacts<1, 1, 4>;
  using Terms = TermList<LoopJoints<3>, DampedSprings<1>, CoordinateSprings<1>>;
};

// lengths in m, masses in kg, moments in kg m^2; names of the publications
constexpr Real m1 = .04325, m2 = .00365, m3 = .02373, m4 = .00706, m5 = .07050, m6 = .00706, m7 = .05498;
constexpr Real I1 = 2.194e-6, I2 = 4.410e-7, I3 = 5.255e-6, I4 = 5.667e-7, I5 = 1.169e-5, I6 = 5.667e-7,
               I7 = 1.912e-5;
constexpr Real xa = -.06934, ya = -.00227, xb = -.03635, yb = .03273, xc = .014, yc = .072;
constexpr Real c0 = 4530, lo = .07785, mom = .033;
constexpr Real d = .028, da = .0115, e = .02, ea = .01421, rr = .007, ra = .00092, ss = .035, sa = .01874,
               sb = .01043, sc = .018, sd = .02, ta = .02308, tb = .00916, u = .04, ua = .01228, ub = .00449,
               zf = .02, zt = .04, fa = .01421;
// coordinates beta, Theta, gamma, Phi, delta, Omega, epsilon at the start and at 0.03 s, rad
constexpr std::array<Real, 7> start{
    -0.0617138900142764, 0, 0.455279819163070, 0.222668390165886, 0.487364979543843, -0.222668390165886,
    1.23054744454982};
constexpr std::array<Real, 7> published{15.81077119629904,   -15.75637105984298, 0.04082224013073101,
                                        -0.5347301163226948, 0.5244099658805304, 0.5347301163226948,
                                        1.048080741042263};

/// Place of a body whose x axis is at an angle from the world's.
Pose at(const Vec3& p, Real angle) { return {.p = p, .q = exp_so3(Vec3(0, 0, angle))}; }
Vec3 toward(Real angle, Real length) { return length * Vec3(std::cos(angle), std::sin(angle), 0); }

template <class I>
struct Mechanism : Running<Squeezer<I>> {
  using Running<Squeezer<I>>::par;
  using Running<Squeezer<I>>::x;

  explicit Mechanism(Real h) {
    par.h = h;
    par.num_bodies = 0;
    const auto [beta, Theta, gamma, Phi, delta, Omega, epsilon] = start;
    const Vec3 A(xa, ya, 0), B(xb, yb, 0), C(xc, yc, 0), K = toward(beta, rr);
    const Real of_4 = Phi + delta - pi / 2, of_7 = epsilon - pi / 2;  // directions of bodies 4 and 7
    // body frames: x toward the next joint
    add(m1, I1, world, Vec3::Zero(), at(toward(beta, ra), beta));
    add(m2, I2, 0, K, at(K - toward(beta + Theta, da), beta + Theta));
    add(m3, I3, world, B, at(B + toward(gamma - pi / 2, sa) + toward(gamma, sb), gamma));
    add(m5, I5, world, A, at(A + toward(delta, tb) + toward(delta - pi / 2, ta), delta));
    const Vec3 H = A + toward(delta, zt);
    add(m4, I4, 3, H, at(H + toward(of_4, e - ea), of_4));
    add(m7, I7, world, A, at(A + toward(of_7, ua) + toward(epsilon, ub), of_7));
    const Vec3 E = A + toward(of_7, u);
    add(m6, I6, 5, E, at(E + toward(Omega + epsilon, zf - fa), Omega + epsilon));
    const Vec3 P = K - toward(beta + Theta, d);
    for (const std::uint32_t b : {2u, 4u, 6u}) {
      auto& loops = par.terms.template of<0>();
      loops.list[loops.size++] = {
          .kind = JointKind::hinge, .a = 1, .b = b, .P = frame_on(1, P), .C = frame_on(b, P)};
    }
    auto& springs = par.terms.template of<1>();
    const Vec3 D = B + toward(gamma, sd) + toward(gamma - pi / 2, sc);
    springs.list[springs.size++] = {.a = {.p = C}, .b = {.on = 2, .p = frame_on(2, D).p}, .k = c0, .l_0 = lo};
    // the torque, as that of a spring so soft and long that it does not change
    constexpr Real soft = 1e-10;
    auto& torques = par.terms.template of<2>();
    torques.list[torques.size++] = {.of = {{{.body = 0}, {}}}, .size = 1, .y_0 = mom / soft, .k = soft};
    EXPECT_EQ(validate(par), Invalid::nothing);
    start_turns(par, x);
  }

  JointFrame frame_on(std::size_t i, const Vec3& p_W) const {
    const Pose& X_WB = x.bodies[i].x.X_WB;
    return {.p = to_body(X_WB.q, p_W - X_WB.p), .R = X_WB.q.conjugate().toRotationMatrix()};
  }
  void add(Real m, Real I_z, std::size_t parent, const Vec3& anchor, const Pose& X_WB) {
    const std::size_t i = par.num_bodies++;
    par.bodies[i].body = rigid_body(m, Vec3(I_z, I_z, I_z).asDiagonal());
    place(x, i, {.X_WB = X_WB, .V_WB = {}});
    auto& joint = par.bodies[i].joint;
    joint.kind = JointKind::hinge;
    joint.parent = parent;
    joint.P = parent == world ? JointFrame{.p = anchor, .R = Mat3::Identity()} : frame_on(parent, anchor);
    joint.C = frame_on(i, anchor);
  }
  /// Returns the published coordinates, from those of the joints, which are zero at the start.
  std::array<Real, 7> coordinates() const {
    const auto q = [&](std::size_t i) { return x.bodies[i].joint.q[0]; };
    const std::array<Real, 7> turned{q(0), q(1), q(2), q(4), q(3), q(6), q(5)};
    std::array<Real, 7> y = start;
    for (std::size_t i = 0; i < 7; ++i) y[i] += turned[i];
    return y;
  }
};

template <class I>
Real error(Real h) {
  const auto run = std::make_unique<Mechanism<I>>(h);
  for (long n = 0; n < std::lround(0.03 / h); ++n) {
    run->step();
    EXPECT_EQ(run->out.fault, Fault::none) << "step " << n;
  }
  Real most = 0;
  const std::array<Real, 7> y = run->coordinates();
  for (std::size_t i = 0; i < 7; ++i) most = std::max(most, std::abs(y[i] - published[i]));
  return most;
}

TEST(Squeezer, MovesAsPublished) {
  const Real e_1 = error<TrBdf2>(4e-5), e_2 = error<TrBdf2>(2e-5), e_3 = error<TrBdf2>(1e-5);
  const Real euler_1 = error<ImplicitEuler>(1e-5), euler_2 = error<ImplicitEuler>(5e-6);
  std::printf("tr-bdf2: %.1e, %.1e, %.1e rad, order %.2f; implicit-euler: %.1e, %.1e rad\n", e_1, e_2, e_3,
              std::log2(e_2 / e_3), euler_1, euler_2);
  EXPECT_GT(std::log2(e_2 / e_3), 1.8);
  EXPECT_LT(e_3, 1e-2);
  EXPECT_GT(std::log2(euler_1 / euler_2), 0.7);
}

}  // namespace
}  // namespace godobject::test_squeezer
