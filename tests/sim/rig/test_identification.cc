// The mechanics of simulated devices, found by moving their joints over simulated buses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "hal/rig/excitation.h"
#include "sim/rig/link.h"

namespace godobject::test::test_identification {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double cycle_s = 1e-3;
const Vec3 g_W(0, 0, -9.81);

RigParams device(const std::vector<DeviceJoint>& joints, double joint_per_motor) {
  RigParams rig;
  rig.buses = {{.name = "can0"}};
  rig.tree.joints = joints;
  rig.tree.handles = {{.body = "tool", .joint = joints.back().name, .X_LH = {.p = Vec3(0.2, 0, 0)}}};
  for (std::size_t i = 0; i < joints.size(); ++i) {
    DriveParams drive;
    drive.joint = joints[i].name;
    drive.node_id = static_cast<std::uint8_t>(i + 1);
    drive.sign = i == 1 ? -1 : 1;
    drive.torque_rated_Nm = drive.torque_max_Nm = 0.2;
    drive.torque_rate_Nm_per_s = 100;
    drive.joint_per_motor_rad = joint_per_motor;
    drive.calibration.counts_per_unit = 2e5;
    rig.drives.push_back(drive);
  }
  return rig;
}

RigParams slides() {
  return device({{.name = "x", .kind = DeviceJointKind::slider, .axis_J = Vec3::UnitX()},
                 {.name = "z", .kind = DeviceJointKind::slider, .axis_J = Vec3::UnitZ()}},
                0.02);
}

/// Shoulder and elbow of an arm in a vertical plane.
RigParams arm() {
  return device({{.name = "shoulder", .X_PJ = {.p = Vec3(0, 0, 0.3)}, .axis_J = Vec3::UnitY()},
                 {.name = "elbow", .X_PJ = {.p = Vec3(0.2, 0, 0)}, .axis_J = Vec3::UnitY()}},
                0.1);
}

class NoHand final : public Hand {
 public:
  bool moves_joints() const noexcept override { return true; }
  JointTarget joints(double) const noexcept override { return {JointVector::Zero(2), JointVector::Zero(2)}; }
  Target target(std::size_t, double) const noexcept override { return {}; }
  bool presses_clutch(std::size_t, double) const noexcept override { return false; }
  bool presses_hold(double) const noexcept override { return false; }
};

struct Plants {
  double between(double a, double b) { return std::uniform_real_distribution(a, b)(random); }
  /// Returns a joint of these ranges without a hand.
  JointPlant joint(double max_inertia, double max_damping, double least_friction, double max_friction) {
    return {.inertia = between(max_inertia / 5, max_inertia),
            .damping = between(max_damping / 10, max_damping),
            .friction = between(least_friction, max_friction),
            .hand_stiffness = 0,
            .hand_damping = 0};
  }
  std::mt19937 random;
};

/// A simulated device with the links of `truth`, and a host with the parameters `known`.
class Bench {
 public:
  Bench(const RigParams& known, const RigParams& truth, const PlantConfig& plant)
      : known_(known),
        link_({.rig = truth, .plant = plant, .wire = {}, .faults = {}, .shows_force = true}, cycle_s,
              std::make_shared<NoHand>(), 50'000),
        rig_(known_, cycle_s, link_.buses()) {}

  /// Runs the whole excitation. Returns the reason why it gave up.
  std::string run(Excitation& excitation) {
    exchange(true);
    for (int k = 0; k < 3000 && !rig_.ready(); ++k) {
      static_cast<void>(rig_.command({}, now_));
      exchange(false);
    }
    EXPECT_TRUE(rig_.arm()) << rig_.fault_text();
    const KinematicTree tree(known_.tree);
    std::array<Wrench, 1> F;
    double square = 0;
    int n = 0;
    for (bool goes_on = true; goes_on && !any(rig_.faults());) {
      static_cast<void>(rig_.command(F, now_));
      const DeviceSample sample = exchange(false);
      F = {};
      goes_on = excitation.step(rig_, sample.q, sample.valid, F);
      if (sample.q_dot.cwiseAbs().maxCoeff() < 0.3 * excitation.peak_speed()) continue;
      square += tree.at(sample.q).joint_torques(F).squaredNorm();
      ++n;
    }
    displayed_rms = std::sqrt(square / std::max(n, 1));
    EXPECT_EQ(rig_.fault_text(), "");
    rig_.disarm();
    for (int k = 0; k < 100; ++k) {
      static_cast<void>(rig_.command({}, now_));
      exchange(false);
    }
    for (std::size_t i = 0; i < rig_.num_drives(); ++i) EXPECT_EQ(link_.rig().applied_torque_Nm(i), 0);
    return excitation.why_not();
  }

  double displayed_rms = 0;  // torque beside the compensation while a joint moves, N m or N

 private:
  DeviceSample exchange(bool starting) {
    now_ = link_.begin_cycle(0);
    if (starting) rig_.start(now_);
    rig_.receive(now_);
    rig_.sync(now_);
    const Nanoseconds deadline = now_ + 750'000;
    do {
      now_ = link_.wait(deadline);
      rig_.receive(now_);
    } while (!rig_.complete() && now_ < deadline);
    return rig_.read(now_);
  }

  RigParams known_;
  SimLink link_;
  Rig rig_;
  Nanoseconds now_ = 0;
};

struct Result {
  std::string why_not;
  Identification found;
  double displayed_rms = 0;
};

Result identified(const RigParams& known, const RigParams& truth, const PlantConfig& plant,
                  const ExcitationParams& params) {
  EXPECT_THAT(Excitation::complaints(known, params), IsEmpty());
  Bench bench(known, truth, plant);
  PlantConfig stated;
  stated.inertia = known.tree.joints[0].kind == DeviceJointKind::slider ? 0.1 : 1e-3;  // as scenes have it
  Excitation excitation(known, stated, cycle_s, params);
  Result out{.why_not = bench.run(excitation), .found = {}, .displayed_rms = bench.displayed_rms};
  if (out.why_not.empty())
    out.found = identify({.tree = known.tree, .gravity_W = g_W, .period_s = cycle_s}, excitation.records());
  return out;
}

void expect_plant(const IdentifiedJoint& found, const JointPlant& truth) {
  std::printf(
      "joint %zu: inertia %.5f (%.5f) +- %.1g, damping %.4f (%.4f) +- %.1g, friction %.4f (%.4f) +- %.1g, "
      "residual %.2g of %.2g\n",
      found.joint, found.inertia.value, truth.inertia, found.inertia.error, found.damping.value,
      truth.damping, found.damping.error, found.friction.value, truth.friction, found.friction.error,
      found.residual_rms, found.torque_rms);
  EXPECT_NEAR(found.inertia.value, truth.inertia, 0.05 * truth.inertia);
  EXPECT_NEAR(found.damping.value, truth.damping, 0.05 * truth.damping + 0.02 * truth.friction);
  EXPECT_NEAR(found.friction.value, truth.friction, 0.03 * truth.friction);
}

/// Returns the host's parameters with the found weights, and the compensation of them and of the friction.
RigParams compensated(RigParams rig, const Identification& found) {
  rig.compensation.gravity_W = g_W;
  for (const IdentifiedJoint& joint : found.joints) {
    rig.compensation.friction.push_back(0.9 * joint.friction.value);
    rig.compensation.certain_speed.push_back(0.01);
    if (!joint.has_weight) continue;
    rig.tree.joints[joint.joint].mass = joint.mass;
    rig.tree.joints[joint.joint].p_LM = joint.p_LM;
  }
  return rig;
}

TEST(Identification, FindsSlidesAndTheirWeight) {
  const ExcitationParams params{.joints = {0, 1}, .amplitude = {0.02, 0.02}, .period_s = 1, .torque = 0.9};
  Plants plants{.random = std::mt19937(1)};
  for (int trial = 0; trial < 4; ++trial) {
    RigParams truth = slides();
    PlantConfig plant;
    plant.gravity_W = g_W;
    for (const char* name : {"x", "z"}) plant.joints.push_back({name, plants.joint(0.5, 5, 2, 3)});
    truth.tree.joints[1].mass = plants.between(0.05, 0.2);
    const Result result = identified(slides(), truth, plant, params);
    ASSERT_EQ(result.why_not, "");
    ASSERT_THAT(result.found.errors, IsEmpty());
    for (std::size_t i = 0; i < 2; ++i) expect_plant(result.found.joints[i], plant.joints[i].plant);
    EXPECT_FALSE(result.found.joints[0].has_weight);
    EXPECT_TRUE(result.found.joints[1].has_weight);
    EXPECT_NEAR(result.found.joints[1].mass, truth.tree.joints[1].mass, 3e-3);

    const RigParams lighter = compensated(slides(), result.found);
    const double displayed_rms = identified(lighter, truth, plant, params).displayed_rms;
    std::printf("torque while moving: %.3g, compensated %.3g\n", result.displayed_rms, displayed_rms);
    EXPECT_LT(displayed_rms, 0.7 * result.displayed_rms);
  }
}

TEST(Identification, FindsAnArmAndItsWeight) {
  const ExcitationParams params{.joints = {0, 1}, .amplitude = {0.3, 0.3}, .period_s = 1.5, .torque = 0.9};
  Plants plants{.random = std::mt19937(2)};
  for (int trial = 0; trial < 4; ++trial) {
    RigParams truth = arm();
    PlantConfig plant;
    plant.gravity_W = g_W;
    plant.joints = {{"shoulder", plants.joint(1e-2, 5e-2, 0.26, 0.35)},
                    {"elbow", plants.joint(5e-3, 5e-2, 0.08, 0.15)}};
    for (DeviceJoint& joint : truth.tree.joints) {
      joint.mass = plants.between(0.02, 0.05);
      joint.p_LM = Vec3(plants.between(0.05, 0.15), 0.02, plants.between(-0.03, 0.03));
    }
    const Result result = identified(arm(), truth, plant, params);
    ASSERT_EQ(result.why_not, "");
    ASSERT_THAT(result.found.errors, IsEmpty());
    for (std::size_t i = 0; i < 2; ++i) expect_plant(result.found.joints[i], plant.joints[i].plant);
    // Masses and levers are not determined by torques, weights are, in every pose.
    const RigParams lighter = compensated(arm(), result.found);
    const KinematicTree is(lighter.tree), was(truth.tree);
    for (int pose = 0; pose < 20; ++pose) {
      const JointVector q = Eigen::Vector2d(plants.between(-0.5, 0.5), plants.between(-0.5, 0.5));
      EXPECT_LT((is.at(q).weight_torques(g_W) - was.at(q).weight_torques(g_W)).cwiseAbs().maxCoeff(), 5e-3);
    }
    const double displayed_rms = identified(lighter, truth, plant, params).displayed_rms;
    std::printf("torque while moving: %.3g, compensated %.3g\n", result.displayed_rms, displayed_rms);
    EXPECT_LT(displayed_rms, 0.7 * result.displayed_rms);
  }
}

TEST(Identification, TooSmallAnExcitationIsRefused) {
  PlantConfig plant{{.inertia = 0.1, .damping = 1, .friction = 8, .hand_stiffness = 0, .hand_damping = 0}};
  const Result stuck = identified(slides(), slides(), plant,
                                  {.joints = {0}, .amplitude = {0.02}, .period_s = 1, .torque = 0.5});
  EXPECT_EQ(stuck.why_not, "");
  EXPECT_THAT(stuck.found.errors, Contains(HasSubstr("joint 'x'")));
  EXPECT_THAT(Excitation::complaints(slides(), {.joints = {0}, .amplitude = {1e-4}}),
              Contains(HasSubstr("20 counts of its sensor")));
}

TEST(Identification, AJointThatFallsEndsTheRun) {
  RigParams truth = arm();
  truth.tree.joints[1].mass = 3;
  truth.tree.joints[1].p_LM = Vec3(0.2, 0, 0);
  PlantConfig plant{{.inertia = 0.1, .damping = 0.1, .friction = 0, .hand_stiffness = 0, .hand_damping = 0}};
  plant.gravity_W = g_W;
  const Result fallen = identified(arm(), truth, plant, {.joints = {0}, .amplitude = {0.3}});
  EXPECT_THAT(fallen.why_not, HasSubstr("joint '"));
}

}  // namespace
}  // namespace godobject::test::test_identification
