// The grasper over the ranges of stiffness, mass, step and speed that a scene may have: finite, bounded and
// joined, and nothing grows with time.
#include <iostream>
#include <vector>

#include "tests/core/joint/grasper_tool.h"
#include "tests/core/joint/usual_scene.h"
#include "tests/support/share.h"

namespace godobject::test_tool_stability {
namespace {

/// Extremes of a run.
struct Passed {
  Drift drift;
  Real energy = 0;  // highest of tool and coupling, by the highest of a tool that moves with the device
  bool fault = false;
};

template <class I>
Passed follow(GrasperTool<I>& tool, Real seconds) {
  Passed p;
  Real device_energy = 0;
  for (Real end = tool.time() + seconds; tool.time() < end;) {
    tool.follow();
    p.fault |= any(tool.out.fault);
    p.drift = worst(p.drift, tool.drift());
    p.energy = std::max(p.energy, tool.energy());
    device_energy = std::max(device_energy, tool.device_energy(tool.time()));
  }
  p.energy /= device_energy;
  return p;
}

std::ostream& operator<<(std::ostream& os, const Passed& p) {
  return os << "drift " << p.drift.m << " m " << p.drift.rad << " rad, energy " << p.energy;
}

template <class I>
class ToolStability : public ::testing::Test {};
TYPED_TEST_SUITE(ToolStability, BothIntegrators);

/// Coupling from 1 to 1e10 N/m. With a weak spring the tool overshoots: up to twice the device's energy.
TYPED_TEST(ToolStability, AnyStiffnessAtAnySpeedOfTheDevice) {
  test::Share share;
  for (const Real rate : {2.0, 20.0})
    for (int decade = 0; decade <= 10; ++decade) {
      if (!share.takes()) continue;
      GrasperTool<TypeParam> tool(
          {.stiffness = std::pow(10, decade), .motion = GrasperMotion::with_peak_rate(rate)});
      const Passed p = follow(tool, 3);
      SCOPED_TRACE(testing::Message() << "stiffness 1e" << decade << ", " << rate << " rad/s: " << p);
      EXPECT_FALSE(p.fault);
      EXPECT_LT(p.energy, 2.5);
      // (h w)^2 of the size of the tool, at most
      const Real turn = rate * tool.par.h;
      EXPECT_LT(p.drift.m, 0.1 * turn * turn);
      EXPECT_LT(p.drift.rad, 2 * turn * turn);
    }
}

TYPED_TEST(ToolStability, JawsAMillionTimesLighterThanTheTube) {
  for (const Real ratio : {1e-6, 1e-3, 1.0}) {
    GrasperTool<TypeParam> tool({.jaw_mass = 0.08 * ratio});
    const Passed p = follow(tool, 10);
    SCOPED_TRACE(testing::Message() << "ratio " << ratio << ": " << p);
    EXPECT_FALSE(p.fault);
    EXPECT_LT(p.energy, 1.1);
    EXPECT_LT(p.drift.m, 1e-7);
    EXPECT_LT(p.drift.rad, 1e-6);
  }
}

/// Drift falls with the cube of the step as long as the device's motion is smooth.
TYPED_TEST(ToolStability, AnyStep) {
  for (const Real h : {1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2})
    for (const Real stiffness : {1.0, 1e3, 1e7, 1e10}) {
      GrasperTool<TypeParam> tool({.h = h, .stiffness = stiffness});
      const Passed p = follow(tool, 2);
      SCOPED_TRACE(testing::Message() << "h " << h << ", stiffness " << stiffness << ": " << p);
      EXPECT_FALSE(p.fault);
      // at 1e10 N/m and 10 ms the drift itself loads the springs: four of them by the allowed drift, 8 J
      EXPECT_LT(p.energy, 8);
      EXPECT_LT(p.drift.m, 20 * h * h * h);
      EXPECT_LT(p.drift.rad, 1000 * h * h * h);
    }
}

/// Repeats the device's loop; the samples of one loop are computed once.
template <class I>
void expect_no_growing_drift(long num_loops) {
  GrasperTool<I> tool;
  const std::size_t length = static_cast<std::size_t>(std::lround(GrasperMotion::period / tool.par.h));
  std::vector<std::array<PoseDevice::Input, 4>> samples(length);
  for (std::size_t n = 0; n < length; ++n) {
    tool.feed(static_cast<Real>(n + 1) * tool.par.h);
    for (std::size_t i = 0; i < 4; ++i) samples[n][i] = tool.in.devices[i];
  }
  std::array<Drift, 10> tenths;
  for (long loop = 0; loop < num_loops; ++loop)
    for (std::size_t n = 0; n < length; ++n) {
      for (std::size_t i = 0; i < 4; ++i) tool.in.devices[i] = samples[n][i];
      tool.step();
      if (n % 5 != 0) continue;
      Drift& tenth = tenths[static_cast<std::size_t>(loop * 10 / num_loops)];
      tenth = worst(tenth, tool.drift());
    }
  EXPECT_EQ(tool.x.tick, static_cast<std::uint64_t>(num_loops) * length);  // no step was refused
  std::cout << I::name << ", " << static_cast<double>(tool.x.tick) << " steps: drift " << tenths[0].m << " m "
            << tenths[0].rad << " rad in the first tenth, " << tenths[9].m << " m " << tenths[9].rad
            << " rad in the last\n";
  EXPECT_LE(tenths[9].m, 1.01 * tenths[0].m);
  EXPECT_LE(tenths[9].rad, 1.01 * tenths[0].rad);
  EXPECT_LT(tenths[0].m, 1e-7);
}

#ifdef NDEBUG
constexpr long loops = 1000;
#else
constexpr long loops = 10;  // builds with assertions and sanitizers take a hundred times as long
#endif
TEST(ToolDrift, DoesNotGrowInTenMillionStepsOfImplicitEuler) {
  expect_no_growing_drift<ImplicitEuler>(loops);
}
TEST(ToolDrift, DoesNotGrowInAMillionStepsOfTrBdf2) {
  expect_no_growing_drift<TrBdf2>(std::max(10L, loops / 10));
}

/// Jaws without a coupling hang in gravity on the driven tube, and swing with it.
TYPED_TEST(ToolStability, UndrivenJawsHangOnTheTube) {
  GrasperTool<TypeParam> tool;
  tool.par.gravity_W = Vec3(3, -4, 8.5);
  for (const std::size_t i : {left_jaw, right_jaw}) tool.par.bodies[i].coupling = {};
  const Real before = tool.energy();
  for (int n = 0; n < 10000; ++n) {
    tool.follow();
    ASSERT_FALSE(any(tool.out.fault));
    ASSERT_LT(tool.drift().m, 1e-5);
    ASSERT_LT(tool.drift().rad, 1e-3);
    // a jaw may fall through the tool's size; the hand swings it with 1 m/s
    ASSERT_LT(tool.energy() - before, 0.5);
  }
}

/// The device jumps within its range every 100 steps. Joints violated by stiff springs, which throw the
/// bodies across in a step, are closed by the next jump.
TYPED_TEST(ToolStability, JumpsOfTheDevice) {
  Random random(1);
  test::Share share;
  for (const Real h : {1e-3, 1e-2})
    for (int decade = 2; decade <= 10; decade += 2) {
      if (!share.takes()) continue;
      GrasperTool<TypeParam> tool({.h = h, .stiffness = std::pow(10, decade)});
      for (int jump = 0; jump < 100; ++jump) {
        tool.feed(random.uniform(0, GrasperMotion::period));
        for (std::size_t i = 0; i < 4; ++i) tool.in.devices[i].target.V_WD = {};
        tool.step(100);
        ASSERT_EQ(tool.x.tick, static_cast<std::uint64_t>(100 * (jump + 1)));  // no step was refused
        ASSERT_LT(tool.drift().m, 1e-6) << "h " << h << ", stiffness 1e" << decade;
        ASSERT_LT(tool.drift().rad, 1e-4) << "h " << h << ", stiffness 1e" << decade;
      }
    }
}

/// All samples lost for a while, or the device disengaged and engaged, during the motion.
TYPED_TEST(ToolStability, GapsOfTheDevice) {
  GrasperTool<TypeParam> tool;
  for (std::size_t i = 0; i < 4; ++i) tool.par.bodies[i].device = {.rise = 0.5, .lost = 0.02};
  tool.par.gravity_W = Vec3(0, 0, 9.81);
  const auto within = [&](Real from, Real to) { return tool.time() >= from && tool.time() < to; };
  for (int n = 0; n < 10000; ++n) {
    for (std::size_t i = 0; i < 4; ++i) {
      tool.in.devices[i].valid = !(within(1, 1.01) || within(2, 2.5));
      tool.in.devices[i].engaged = !within(4, 4.3) && !(i == left_jaw && within(6, 7));
    }
    tool.follow();
    ASSERT_FALSE(any(tool.out.fault));
    ASSERT_LT(tool.drift().m, 5e-6) << tool.time();
    ASSERT_LT(tool.drift().rad, 2e-4) << tool.time();
    ASSERT_LT(kinetic_energy(tool.par, tool.x), 4) << tool.time();  // of a fall through 1 m and more
  }
  const Vec3 off = tool.x.bodies[tube].x.X_WB.p - tool.motion.at(tool.time())[tube].X_WD.p;
  EXPECT_LT(off.norm(), 2e-3);  // back on the device, but for gravity
}

}  // namespace
}  // namespace godobject::test_tool_stability
