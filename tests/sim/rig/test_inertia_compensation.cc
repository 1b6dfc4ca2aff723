// Drives that move the inertia of their own device: filter, felt mass through buses, and energy.
#include "hal/rig/inertia_compensation.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <random>
#include <vector>

#include "hal/rig/passivity_controller.h"
#include "platform/session/sampled_axis.h"
#include "sim/rig/plant.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/simulated_rig.h"

namespace godobject::test::test_inertia_compensation {
namespace {

constexpr double pi = std::numbers::pi;

TEST(InertiaCompensation, AConstantAccelerationGivesItsTorque) {
  InertiaCompensation compensation(0.2, 30, 1e-3);
  double torque = 0;
  for (int k = 0; k < 1000; ++k) torque = compensation.update(0.5 * 3 * 1e-6 * k * k, true, true);
  EXPECT_NEAR(torque, 0.2 * 3, 1e-9);
}

TEST(InertiaCompensation, SamplesAtEveryThirdPeriodAreEquallySpaced) {
  InertiaCompensation compensation(0.2, 30, 1e-3);
  double torque = 0;
  for (int k = 0; k < 1002; ++k) {
    const int sampled = k / 3 * 3;
    torque = compensation.update(0.5 * 3 * 1e-6 * sampled * sampled, k % 3 == 0, true);
  }
  EXPECT_NEAR(torque, 0.2 * 3, 0.01);
}

TEST(InertiaCompensation, ALostJointHasNoTorqueAndBeginsAgainAtRest) {
  InertiaCompensation compensation(0.2, 30, 1e-3);
  for (int k = 0; k < 100; ++k) compensation.update(1e-6 * k * k, true, true);
  EXPECT_EQ(compensation.update(0.01, false, false), 0);
  EXPECT_EQ(compensation.update(5, true, true), 0);  // the way in between is no motion
  EXPECT_NE(compensation.update(5.001, true, true), 0);
  compensation.reset();
  EXPECT_EQ(compensation.update(-3, true, true), 0);
}

// ---- felt mass ------------------------------------------------------------------------------------

constexpr double mass = 0.3, damping = 2, radius = 0.02;  // kg, N s/m, m/rad

RigParams slider(double share, double cutoff_Hz, int status_every) {
  RigParams rig = slider_rig_params(radius, 1e6);
  DriveParams& drive = rig.drives.front();
  drive.torque_rated_Nm = 0.01;
  drive.torque_max_Nm = 0.2;
  drive.torque_rate_Nm_per_s = 1000;
  drive.status_every_nth_sync = static_cast<std::uint8_t>(status_every);
  if (share > 0) rig.compensation.inertia = {share * mass};
  rig.compensation.inertia_cutoff = 2 * pi * cutoff_Hz;
  return rig;
}

/// Returns the force of the hand for its coordinate at a frequency, N/m.
std::complex<double> felt(double share, double cutoff_Hz, double f_Hz, int status_every = 1,
                          bool controlled = false) {
  SimulatedRig rig(
      slider(share, cutoff_Hz, status_every), true,
      PlantConfig{
          {.inertia = mass, .damping = damping, .friction = 0, .hand_stiffness = 2000, .hand_damping = 20}});
  const double w = 2 * pi * f_Hz, amplitude = 0.02;
  double began = 0;
  rig.q_ref = [&](double t) { return JointVector::Constant(1, amplitude * std::sin(w * (t - began))); };
  rig.q_ref_dot = [&](double t) {
    return JointVector::Constant(1, amplitude * w * std::cos(w * (t - began)));
  };
  if (controlled) {
    const SampledAxis axis{
        .inertia = mass, .damping = damping, .K = 0, .carried = share * mass, .cutoff = 2 * pi * cutoff_Hz};
    EXPECT_GT(axis.needed(), 2 * damping);
    rig.rig->control_passivity(std::array{PassivityParams{.inertia = mass,
                                                          .damping = damping,
                                                          .needed = axis.needed(),
                                                          .resolution = 1e-6,
                                                          .carried = axis.carried}});
  }
  EXPECT_TRUE(rig.boot()) << rig.rig->fault_text();
  EXPECT_TRUE(rig.rig->arm());
  began = 1e-9 * static_cast<double>(rig.now);
  std::complex<double> X = 0, F = 0;
  const int period = static_cast<int>(std::lround(1000 / f_Hz));
  for (int k = 0; k < 5 * period; ++k) {
    rig.cycle();
    if (k < 2 * period) continue;
    const auto turned = std::polar(1.0, -w * 1e-9 * static_cast<double>(rig.now));
    X += rig.plant.q()(0) * turned;
    F += rig.plant.hand_torque()(0) * turned;
  }
  EXPECT_EQ(rig.rig->faults(), RigFault::none) << rig.rig->fault_text();
  return F / X;
}

double felt_mass(double share, double cutoff_Hz, double f_Hz, int status_every = 1, bool controlled = false) {
  const double w = 2 * pi * f_Hz;
  return -felt(share, cutoff_Hz, f_Hz, status_every, controlled).real() / (w * w);
}

TEST(InertiaCompensation, TheHandFeelsTheShareThatRemains) {
  EXPECT_NEAR(felt_mass(0, 10, 1), mass, 0.01 * mass);
  for (const double share : {0.3, 0.6, 0.9})
    EXPECT_NEAR(felt_mass(share, 10, 1), (1 - share) * mass, 0.05 * mass) << share;
  EXPECT_NEAR(felt_mass(0.6, 10, 1, 2), 0.4 * mass, 0.05 * mass);
}

// An axis that needs 2.8 times its damping feels 0.49 of its mass instead of 0.4.
TEST(InertiaCompensation, AControllerLeavesMostOfItInSlowMotion) {
  EXPECT_LT(felt_mass(0.6, 10, 1, 1, true), 0.55 * mass);
}

// m_c a of the two low-passes, 1.5 periods late: Z = -(m - m_c H) w^2 + j b w.
TEST(InertiaCompensation, AboveTheCutoffItFadesAsItsFilter) {
  constexpr double share = 0.6, cutoff_Hz = 5;
  for (const double f_Hz : {1.0, 2.0, 5.0, 10.0}) {
    const double w = 2 * pi * f_Hz, x = f_Hz / cutoff_Hz;
    const std::complex<double> lag = 1.0 + std::complex<double>(0, x);
    const std::complex<double> H = std::polar(1.0, -1.5e-3 * w) / (lag * lag);
    const std::complex<double> law = -mass * w * w * (1.0 - share * H) + std::complex<double>(0, damping * w);
    EXPECT_LT(std::abs(felt(share, cutoff_Hz, f_Hz) - law), 0.02 * mass * w * w) << f_Hz;
  }
}

TEST(InertiaCompensation, CyclesWithItDoNotAllocate) {
  SimulatedRig rig(slider(0.5, 5, 1), true);
  ASSERT_TRUE(rig.boot() && rig.rig->arm());
  rig.q_ref = [](double t) { return JointVector::Constant(1, 0.01 * std::sin(10 * t)); };
  rig.cycle();
  AllocationGuard guard;
  for (int k = 0; k < 200; ++k) rig.cycle();
  EXPECT_EQ(guard.calls(), 0) << guard.report();
}

// ---- energy ---------------------------------------------------------------------------------------

struct DrawnAxis {
  JointPlant plant;
  SampledAxis axis;
  double count = 1e-6;  // m
  bool controlled = true;
  std::vector<double> hand{0};  // places of the hand, m, each for half a second after a way of half a second
};

DrawnAxis drawn_axis(std::mt19937& random) {
  const auto between = [&](double a, double b) { return std::uniform_real_distribution(a, b)(random); };
  const auto scale = [&](double a, double b) { return a * std::pow(b / a, between(0, 1)); };
  DrawnAxis out;
  out.plant = {.inertia = scale(0.02, 1),
               .damping = scale(0.05, 5),
               .friction = 0,
               .hand_stiffness = scale(20, 5000),
               .hand_damping = between(0, 2) < 1 ? 0 : scale(0.1, 10)};
  out.axis = {.inertia = out.plant.inertia,
              .damping = out.plant.damping,
              .K = 0,
              .period_s = std::array{2.5e-4, 5e-4, 1e-3, 2e-3}[static_cast<std::size_t>(between(0, 4))],
              .delay = static_cast<int>(between(0, 3)),
              .carried = between(0.2, 0.9) * out.plant.inertia,
              .cutoff = 2 * pi * scale(1, 20)};
  out.count = scale(1e-6, 50e-6);
  for (int i = 0; i < 4; ++i) out.hand.push_back(between(-0.1, 0.1));
  return out;
}

/// Returns the place of the hand and its rate, m and m/s.
std::pair<double, double> hand_at(const DrawnAxis& drawn, double t) {
  const auto i = std::min(static_cast<std::size_t>(t), drawn.hand.size() - 2);
  const double s = std::min(1.0, 2 * (t - static_cast<double>(i))), way = drawn.hand[i + 1] - drawn.hand[i];
  return {drawn.hand[i] + way * s * s * (3 - 2 * s), s < 1 ? 2 * way * 6 * s * (1 - s) : 0};
}

/// Returns the largest energy that the drive has added, J, without that dissipated by the device or lent to
/// the carried inertia. Infinite if the axis runs away.
double gained_J(const DrawnAxis& drawn, double time_s) {
  const SampledAxis& axis = drawn.axis;
  SimPlant plant(drawn.plant, 1, true, JointVector::Zero(1), 0);
  InertiaCompensation compensation(axis.carried, axis.cutoff, axis.period_s);
  PassivityController controller({.inertia = axis.inertia,
                                  .damping = axis.damping,
                                  .needed = axis.needed(),
                                  .resolution = drawn.count,
                                  .period_s = axis.period_s,
                                  .delay = axis.delay,
                                  .acts_after = axis.delay,
                                  .energy_J = drawn.controlled ? PassivityParams{}.energy_J : 0,
                                  .carried = axis.carried});
  std::vector<double> pending(static_cast<std::size_t>(axis.delay) + 1, 0);
  const auto period_ns = static_cast<Nanoseconds>(std::llround(1e9 * axis.period_s));
  const int periods = static_cast<int>(std::lround(time_s / axis.period_s));
  double added = 0, gained = 0;
  for (int k = 0; k < periods; ++k) {
    const double q = std::round(plant.q()(0) / drawn.count) * drawn.count;
    const double sent = controller.limit(0, q, true, compensation.update(q, true, true));
    controller.sent(sent);
    pending[static_cast<std::size_t>(k + axis.delay) % pending.size()] = sent;
    const double acts = pending[static_cast<std::size_t>(k) % pending.size()];
    plant.set_motor_torque(0, acts);
    const auto [place, rate] = hand_at(drawn, (k + 1) * axis.period_s);
    for (Nanoseconds ns = SimPlant::substep_ns; ns <= period_ns; ns += SimPlant::substep_ns) {
      const double before = plant.q()(0);
      plant.advance(k * period_ns + ns, JointVector::Constant(1, place), JointVector::Constant(1, rate));
      const double v = plant.q_dot()(0);
      added += acts * (plant.q()(0) - before) - drawn.plant.damping * v * v * 1e-9 * SimPlant::substep_ns;
      gained = std::max(gained, added - 0.5 * axis.carried * v * v);
      if (!(std::abs(plant.q()(0)) < 10)) return std::numeric_limits<double>::infinity();
    }
  }
  return gained;
}

TEST(InertiaCompensation, DrawnAxesInAPassiveHandGainNoEnergy) {
  constexpr int num_axes = 300;
  constexpr double allowed_J = 5e-3;  // as of a controlled wall
  std::mt19937 random(11);
  int failed_without = 0, num_passive = 0;
  double worst = 0, worst_passive = 0;
  for (int i = 0; i < num_axes; ++i) {
    DrawnAxis drawn = drawn_axis(random);
    const double with = gained_J(drawn, 4);
    drawn.controlled = false;
    const double without = gained_J(drawn, 4);
    EXPECT_LE(with, allowed_J) << i << ": " << drawn.axis.inertia << " kg, " << drawn.axis.carried
                               << " moved, " << drawn.axis.damping << " N s/m, needs " << drawn.axis.needed()
                               << ", delay " << drawn.axis.delay << ", " << drawn.axis.period_s
                               << " s, count " << drawn.count << " m, hand " << drawn.plant.hand_stiffness
                               << " N/m " << drawn.plant.hand_damping << " N s/m, with " << with
                               << ", without " << without;
    failed_without += without > allowed_J ? 1 : 0;
    worst = std::max(worst, with);
    if (!drawn.axis.passive()) continue;
    ++num_passive;
    worst_passive = std::max(worst_passive, without);
  }
  std::printf(
      "of %d drawn axes %d gain more than %g mJ without the controller; with it the worst %.2g mJ\n"
      "%d within their margin: without it the worst %.2g mJ\n",
      num_axes, failed_without, 1e3 * allowed_J, 1e3 * worst, num_passive, 1e3 * worst_passive);
  EXPECT_GT(failed_without, num_axes / 5);
  EXPECT_GT(num_passive, num_axes / 20);
  EXPECT_LE(worst_passive, allowed_J);
}

}  // namespace
}  // namespace godobject::test::test_inertia_compensation
