// Nets whose carrier is the last link of a chain on joints: against the oracle, and over drawn masses,
// stiffness and steps.
#include <gtest/gtest.h>

#include "tests/core/net/oracle_net.h"
#include "tests/core/net/usual_scene.h"
#include "tests/oracle/solve.h"
#include "tests/study/joint/oracle_joint.h"

namespace godobject::test_net_on_joints {
namespace {

using oracle::JointType;

inline constexpr Real half = 0.05;  // of a link along x, m

/// Returns two links along x in a row, which fall from rest from the world's origin. Joints turn about y,
/// universal ones about z of the child, too.
oracle::Case two_links(JointType first, JointType second, Real m, const Vec3& I) {
  oracle::Case c;
  c.gravity = Vec3(1, 3, -9.81);
  for (std::size_t i = 0; i < 2; ++i) {
    oracle::Body& link = c.bodies.emplace_back();
    link.name = i == 0 ? "first" : "second";
    link.m = m;
    link.I_B = I.asDiagonal();
    link.start.p = Vec3(half + 2 * half * static_cast<Real>(i), 0, 0);
    oracle::Joint& joint = c.joints.emplace_back();
    joint.type = i == 0 ? first : second;
    joint.child = i;
    if (i > 0) joint.parent = i - 1;
    joint.anchor_P = i == 0 ? Vec3(0, 0, 0) : Vec3(half, 0, 0);
    joint.anchor_C = Vec3(-half, 0, 0);
    joint.axis_P = Vec3::UnitY();
    joint.axis_C = Vec3::UnitZ();
  }
  return c;
}

/// The two links in the core, with a net on the last link.
template <class I>
struct Chain : Running<JointedNetScene<I>> {
  Chain(const oracle::Case& links, const Stuff& stuff, std::uint32_t side, Real h) {
    auto& par = this->par;
    par.h = h;
    par.gravity_W = links.gravity;
    par.num_bodies = 2;
    for (std::size_t i = 0; i < 2; ++i) {
      par.bodies[i].body = rigid_body(links.bodies[i].m, links.bodies[i].I_B);
      static_cast<JointParams&>(par.bodies[i].joint) = joint_params(links.joints[i]);
      place(this->x, i, {.X_WB = {.p = links.bodies[i].start.p}, .V_WB = {}});
      this->in.devices[i] = {};
    }
    add_sheet(par, stuff, side, side, 0.01);
    place_net(par.net, this->x);
    if (validate(par) != Invalid::nothing) throw std::runtime_error("invalid");
  }
};

inline constexpr Real duration = 0.128;  // s
inline constexpr Stuff sheet{.m = 2e-3, .k = 40, .g = 0.05, .k_a = 8, .g_a = 0.02, .carrier = 1};

/// Returns the solution of the oracle for the links, then the nodes.
std::vector<Vec3> solved_exactly(oracle::Case c) {
  const auto chain = std::make_unique<Chain<TrBdf2>>(c, sheet, 4, 1e-3);
  add_net(*chain, c);
  const oracle::Solution solution = oracle::solve(c, std::vector{duration}, 1e-10);
  std::vector<Vec3> p;
  for (const oracle::RigidState& state : solution.states[0]) p.push_back(state.p);
  return p;
}

template <class I>
Real error(const oracle::Case& links, Real h, const std::vector<Vec3>& truth) {
  auto chain = std::make_unique<Chain<I>>(links, sheet, 4, h);
  chain->par.net.max_iterations = 2000;  // to the end
  chain->par.net.tolerance = 1e-13 / (h * h);
  for (long n = 0; n < std::lround(duration / h); ++n) {
    chain->step();
    EXPECT_EQ(chain->out.fault, Fault::none);
  }
  Real most = 0;
  for (std::size_t i = 0; i < 2; ++i) most = std::max(most, (chain->x.bodies[i].x.X_WB.p - truth[i]).norm());
  for (std::size_t n = 0; n < chain->par.net.num_nodes; ++n)
    most = std::max(most, (chain->x.net.nodes[n].p_W - truth[n + 2]).norm());
  return most;
}

template <class I>
void expect_order(const oracle::Case& links, Real least, const std::vector<Vec3>& truth) {
  const Real e_1 = error<I>(links, 1e-3, truth), e_2 = error<I>(links, 5e-4, truth),
             e_3 = error<I>(links, 2.5e-4, truth);
  std::printf("%s: %.2e, %.2e, %.2e m, order %.2f\n", I::name, e_1, e_2, e_3, std::log2(e_2 / e_3));
  EXPECT_GE(std::log2(e_2 / e_3), least);
  EXPECT_LT(e_1, I::order == 1 ? 5e-3 : 2e-4);
}

TEST(NetOnJoints, ConvergesAsItsIntegratorDoes) {
  for (const auto& [first, second] :
       {std::pair{JointType::universal, JointType::hinge}, {JointType::hinge, JointType::universal}}) {
    const oracle::Case links = two_links(first, second, 0.05, Vec3(1e-5, 5e-5, 6e-5));
    const std::vector<Vec3> truth = solved_exactly(links);
    EXPECT_GT((truth[1] - links.bodies[1].start.p).norm(), half) << "the chain swings";
    expect_order<ImplicitEuler>(links, 0.9, truth);
    expect_order<TrBdf2>(links, 1.6, truth);
  }
}

template <class I>
void expect_no_gain() {
  for (unsigned seed = 0; seed < 50; ++seed) {
    Random random(seed);
    const auto kind = [&] { return random.integer(0, 1) == 0 ? JointType::hinge : JointType::universal; };
    const JointType first = kind(), second = kind();
    const Real m = random.log_uniform(1e-2, 1), k = random.log_uniform(1, 1e6),
               m_n = random.log_uniform(1e-5, 1e-1), zeta = random.integer(0, 1) * random.uniform(0, 1),
               h = random.log_uniform(1e-4, 5e-3);
    const Real k_a = k * random.log_uniform(1e-2, 10);
    const Stuff stuff{.m = m_n,
                      .k = k,
                      .g = 2 * zeta * std::sqrt(k * m_n),
                      .k_a = k_a,
                      .g_a = 2 * zeta * std::sqrt(k_a * m_n),
                      .carrier = 1};
    const oracle::Case links = two_links(first, second, m, m * Vec3(2e-4, 1e-3, 1.2e-3));
    auto chain = std::make_unique<Chain<I>>(links, stuff, 5, h);
    for (std::size_t n = 0; n < chain->par.net.num_nodes; ++n)
      chain->x.net.nodes[n].v_W = 0.3 * random.vector();
    EnergyBalance<JointedNetScene<I>> balance;
    balance.start(chain->par, chain->x);
    for (int n = 0; n < 400; ++n) {
      chain->step();
      ASSERT_FALSE(has(chain->out.fault, Fault::state_not_finite)) << "seed " << seed;
      balance.observe(chain->par, chain->x, chain->w, chain->out);
      ASSERT_FALSE(balance.gains()) << I::name << " seed " << seed << " step " << n << ": gains "
                                    << balance.watch().gained() << " J of " << balance.watch().at_work()
                                    << " J; link " << m << " kg, node " << m_n << " kg, k " << k
                                    << ", anchors " << k_a << ", zeta " << zeta << ", h " << h;
    }
  }
}

TEST(NetOnJoints, GainsNoEnergyWithImplicitEuler) { expect_no_gain<ImplicitEuler>(); }
TEST(NetOnJoints, GainsNoEnergyWithTrBdf2) { expect_no_gain<TrBdf2>(); }

}  // namespace
}  // namespace godobject::test_net_on_joints
