// Gaps in the samples of a device, from one step to a hundred: no additional force, no jump.
#include <gtest/gtest.h>

#include "tests/core/contact/contact_scene.h"

namespace godobject::test_sample_gaps {
namespace {

constexpr Real h = 1e-3;
constexpr int num_steps = 12'000;
/// The error of a bridge on a curved motion is small.
constexpr Real tolerance = 1.03;

/// A tool with a haptic device, above the half-space z < 0.
template <class I, class DevicePart>
struct Haptic : Touching<I, 1, 1, DevicePart, 1> {
  using Feedback = LimitedFeedback;
};

struct Hand {
  Vec3 middle_W = Vec3(0, 0, 0.3), amplitude_W{0.16, 0.1, 0.05};
  Vec3 frequency_hz{1.0, 0.6, 0.4};  // up to 1 m/s along x

  Target at(Real t) const {
    const Vec3 w = 2 * pi * frequency_hz, angle = t * w;
    const Vec3 v = amplitude_W.cwiseProduct(w).cwiseProduct(angle.array().sin().matrix());
    const Vec3 p = middle_W - amplitude_W.cwiseProduct(angle.array().cos().matrix());
    const Vec3 w_W = 0.5 * pi * std::sin(2 * pi * t) * Vec3::UnitY();
    return {.X_WD = {.p = p, .q = exp_so3(-0.25 * std::cos(2 * pi * t) * Vec3::UnitY())},
            .V_WD = {.w = w_W, .v = v}};
  }
};

const Hand in_the_air;
/// Up to 6 mm into the plane, dragged along it.
const Hand on_the_plane{
    .middle_W = Vec3(0, 0, 6.5e-3), .amplitude_W = {0.16, 0.1, 2.5e-3}, .frequency_hz = {1, 0.6, 0.4}};

/// The steps that have no sample: seeded, some 3 a second.
std::vector<bool> stalls(unsigned seed, int longest) {
  Random random(seed);
  std::vector<bool> missing(num_steps, false);
  for (int n = 1000; n < num_steps - 1000; n += random.integer(150, 500))
    for (int left = random.integer(1, longest); left > 0 && n < num_steps; --left)
      missing[static_cast<std::size_t>(n++)] = true;
  return missing;
}

struct Felt {
  Real force = 0, torque = 0;        // largest shown, N and N m, after the first second
  Real change = 0, turn_change = 0;  // in a step
  Real coupling_change = 0;          // of the coupling's force, in the first step with a sample
};

template <class I, class DevicePart>
class Run {
 public:
  using S = Haptic<I, DevicePart>;

  explicit Run(Real stale) {
    run_.par.h = h;
    run_.par.bodies[0].body = rigid_body(0.1, Vec3(3.5e-4, 3.5e-4, 2.7e-5).asDiagonal());
    run_.par.bodies[0].coupling = {.k = 1000, .g = 14, .k_r = 1, .g_r = 0.026};
    run_.par.bodies[0].feedback.gains = run_.par.bodies[0].coupling;
    run_.par.bodies[0].device.stale = stale;
    add_sphere(run_.par, 0, Vec3::Zero(), 0.01);
    add_plane(run_.par);
    set_law(run_.par, {.k = 2e4, .c = 7, .mu = 0.3, .k_t = 2e4, .c_t = 7});
    EXPECT_EQ(validate(run_.par), Invalid::nothing);
  }

  Felt feel(const Hand& hand, const std::vector<bool>& missing) {
    Felt felt;
    place(run_.x, 0, {.X_WB = hand.at(0).X_WD, .V_WB = {}});
    last_ = hand.at(0);
    Wrench before;
    for (int n = 1; n < num_steps; ++n) {
      const bool valid = missing.empty() || !missing[static_cast<std::size_t>(n)];
      const bool back = valid && !missing.empty() && missing[static_cast<std::size_t>(n - 1)];
      const Vec3 pull = coupling_at(run_.par, run_.x, 0).F_WB.f;
      give(hand, n, valid);
      run_.step();
      EXPECT_FALSE(any(run_.out.fault));
      EXPECT_EQ(has(run_.out.limited, Limited::held), !valid);
      const Wrench& F = run_.out.bodies[0].feedback.F_D;
      if (n > 1000) {
        felt.force = std::max(felt.force, F.f.norm());
        felt.torque = std::max(felt.torque, F.tau.norm());
        felt.change = std::max(felt.change, (F.f - before.f).norm());
        felt.turn_change = std::max(felt.turn_change, (F.tau - before.tau).norm());
      }
      if (back) {
        const Vec3 now = coupling_at(run_.par, run_.x, 0).F_WB.f;
        felt.coupling_change = std::max(felt.coupling_change, now.norm() - pull.norm());
      }
      before = F;
    }
    return felt;
  }

 private:
  void give(const Hand& hand, int n, bool valid) {
    const Target sample = hand.at(h * n);
    auto& in = run_.in.devices[0];
    in.valid = valid;
    if constexpr (std::is_same_v<DevicePart, RelativeDevice>) {
      if (!valid) return;
      in.dp_W = sample.X_WD.p - last_.X_WD.p;
      in.dphi_W = to_world(last_.X_WD.q, rotation_error(last_.X_WD.q, sample.X_WD.q, Vec3::Zero()).phi_B);
    } else if (valid) {
      in.target = sample;
    }
    last_ = sample;
  }

  Running<S> run_;
  Target last_;
};

template <class Types>
class SampleGaps : public ::testing::Test {};
template <class I, class D>
struct With {
  using Integrator = I;
  using Device = D;
};
using All =
    ::testing::Types<With<TrBdf2, PoseDevice>, With<ImplicitEuler, PoseDevice>, With<TrBdf2, HoldingDevice>,
                     With<ImplicitEuler, HoldingDevice>, With<TrBdf2, RelativeDevice>>;
TYPED_TEST_SUITE(SampleGaps, All);

/// Whatever the sample may be old: the shown force is never more than without the gaps, and keeps its rate.
TYPED_TEST(SampleGaps, ShowNothingThatWasNotThere) {
  using R = Run<typename TypeParam::Integrator, typename TypeParam::Device>;
  for (const Hand& hand : {in_the_air, on_the_plane}) {
    const Felt undisturbed = R(0).feel(hand, {});
    Felt worst;
    for (const Real stale : {0.0, 0.03, 0.2})
      for (const int longest : {1, 3, 10, 30, 99})
        for (const unsigned seed : {1u, 2u, 3u}) {
          const Felt felt = R(stale).feel(hand, stalls(seed, longest));
          EXPECT_LE(felt.force, tolerance * undisturbed.force) << "stale " << stale << ", up to " << longest;
          EXPECT_LE(felt.torque, tolerance * undisturbed.torque)
              << "stale " << stale << ", up to " << longest;
          worst.force = std::max(worst.force, felt.force);
          worst.torque = std::max(worst.torque, felt.torque);
          worst.change = std::max(worst.change, felt.change);
          worst.turn_change = std::max(worst.turn_change, felt.turn_change);
          worst.coupling_change = std::max(worst.coupling_change, felt.coupling_change);
        }
    const FeedbackParams limits;
    EXPECT_LE(worst.change, (1 + 1e-9) * h * limits.max_force_rate);
    EXPECT_LE(worst.turn_change, (1 + 1e-9) * h * limits.max_torque_rate);
    EXPECT_LE(worst.coupling_change, 1.0) << "N more than in the step before";
    std::printf(
        "%.3g N and %.3g N m, without gaps %.3g N and %.3g N m; coupling grows by %.3g N at the most\n",
        worst.force, worst.torque, undisturbed.force, undisturbed.torque, worst.coupling_change);
  }
}

/// Missed time of the host is a gap like any other.
TYPED_TEST(SampleGaps, TimeWithoutAStepIsOne) {
  using Device = typename TypeParam::Device;
  if constexpr (!std::is_same_v<Device, RelativeDevice>) {
    for (const int missed : {1, 3, 10, 99}) {
      DeviceState x;
      x.last.V_WD.v = Vec3(1, 0, 0);
      x.ramp = {.s = 1, .engaged = true};
      pass_time(x, missed * h, h);
      EXPECT_NEAR(x.last.X_WD.p.x(), missed <= bridged_steps ? missed * h : 0, 1e-15);
      Limited limited = Limited::none;
      const CouplingInput pull = begin_coupling_input({}, x, true, true, h, limited);
      EXPECT_EQ(pull.gap.showing, Showing::capped) << missed;
      EXPECT_EQ(pull.fresh, missed > bridged_steps) << missed;
    }
  }
}

}  // namespace
}  // namespace godobject::test_sample_gaps
