// Statistics of a run: errors, limits, faults. Adding a cycle is real-time.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "platform/cli/fault_texts.h"
#include "platform/rt/cyclic.h"
#include "platform/session/record.h"
#include "platform/session/session.h"

namespace godobject {

/// Root mean square and maximum of a pose error.
class PoseErrorStatistics {
 public:
  void add(const PoseError& e) noexcept {
    ++count_;
    sum_sq_.m += e.m * e.m;
    sum_sq_.rad += e.rad * e.rad;
    max_ = {.m = std::max(max_.m, e.m), .rad = std::max(max_.rad, e.rad)};
  }

  std::uint64_t count() const noexcept { return count_; }
  const PoseError& max() const noexcept { return max_; }
  PoseError rms() const noexcept {
    const double n = count_ > 0 ? static_cast<double>(count_) : 1;
    return {.m = std::sqrt(sum_sq_.m / n), .rad = std::sqrt(sum_sq_.rad / n)};
  }

 private:
  std::uint64_t count_ = 0;
  PoseError sum_sq_, max_;
};

/// Largest values of a run.
struct NetStatistics {
  double stretch = 0, deepest = 0, residual = 0;  // l / l_0; m; N
  std::size_t contacts = 0;
  std::uint64_t iterations = 0;  // total of the run
  int most_iterations = 0;       // largest of a step

  void add(const NetReport& net, double stretch_now) noexcept {
    stretch = std::max(stretch, stretch_now);
    deepest = std::max(deepest, static_cast<double>(net.deepest));
    residual = std::max(residual, static_cast<double>(net.residual));
    contacts = std::max(contacts, net.num_contacts);
    iterations += static_cast<std::uint64_t>(net.iterations);
    most_iterations = std::max(most_iterations, net.iterations);
  }
};

/// Peak and mean of a quantity over all cycles.
struct PeakAndMean {
  double peak = 0, sum = 0;

  void add(double x) noexcept {
    peak = std::max(peak, x);
    sum += x;
  }
};

/// Peaks and means of a body's motion and forces.
struct BodyStatistics {
  PeakAndMean speed, turn_rate;                 // m/s, rad/s
  PeakAndMean coupling_force, coupling_torque;  // N, N m; zero for bodies without a target, as the next line
  PeakAndMean displayed_force, displayed_torque;  // wrench displayed to the hand
  PeakAndMean contact_force, contact_torque;

  void add(const BodyView& body) noexcept {
    speed.add(body.V_WB.v.norm());
    turn_rate.add(body.V_WB.w.norm());
    coupling_force.add(body.coupling_B.f.norm());
    coupling_torque.add(body.coupling_B.tau.norm());
    displayed_force.add(body.feedback_D.f.norm());
    displayed_torque.add(body.feedback_D.tau.norm());
    contact_force.add(body.contact_W.f.norm());
    contact_torque.add(body.contact_W.tau.norm());
  }
};
struct JointStatistics {
  std::size_t child = 0;          // index of the child body
  PeakAndMean force{}, torque{};  // N, N m

  void add(const Wrench& F) noexcept {
    force.add(F.f.norm());
    torque.add(F.tau.norm());
  }
};
struct CoordinateStatistics {
  double min = 0, max = 0, sum = 0;  // rad or m

  void add(double q, bool is_first) noexcept {
    min = is_first ? q : std::min(min, q);
    max = is_first ? q : std::max(max, q);
    sum += q;
  }
};

/// Largest values of a run.
struct ContactStatistics {
  double residual = 0, residual_share = 0, deepest = 0;  // N; share of the largest normal force; m
  std::size_t contacts = 0;
  int most_newton_iterations = 0;  // largest of a step

  void add(const ContactReport& step) noexcept {
    residual = std::max(residual, static_cast<double>(step.residual));
    residual_share = std::max(residual_share, static_cast<double>(step.residual_share));
    deepest = std::max(deepest, static_cast<double>(step.deepest));
    contacts = std::max(contacts, step.num_contacts);
    most_newton_iterations = std::max(most_newton_iterations, step.newton_iterations);
  }
};

struct RunStatistics {
  std::vector<BodyStatistics> bodies{};  // all bodies of the scene, see prepare()
  std::vector<JointStatistics> joints{};
  std::vector<CoordinateStatistics> coordinates{};  // as CycleRecord::joint_q
  std::vector<PeakAndMean> drives{};  // absolute value of the commanded torque at the joint, N m, or force, N
  std::vector<double> drive_energy{};  // largest generated energy of each drive's axis, J

  /// Allocates the arrays for this scene.
  void prepare(const SceneConfig& scene, const CycleRecord& at_start) {
    bodies.resize(at_start.bodies.size());
    for (const JointConfig& joint : scene.joints)
      joints.push_back({.child = *body_named(scene, joint.child)});
    coordinates.resize(at_start.joint_q.size());
    drives.resize(at_start.drive_torque.size());
    drive_energy.resize(at_start.drive_energy.size());
  }

  std::uint64_t cycles = 0;
  std::array<Histogram, stage_names.size()> stage_ns;  // time of each stage of a cycle
  Histogram compute_ns;                                // of all stages but the wait for the device
  // Errors over engaged cycles after the ramp. Before, the body moves to the target, or is released.
  PoseErrorStatistics following, sensing, exact_following, encoders;
  std::array<std::uint64_t, run_limits.size()> limit_cycles{};        // number of cycles with that limit
  std::array<std::uint64_t, core_fault_texts.size()> fault_cycles{};  // in the order of core_fault_texts
  RigFault rig_faults = RigFault::none;
  std::uint64_t holds = 0, hold_cycles = 0;  // holds after too many missed deadlines
  std::uint64_t held_cycles = 0;             // those, and cycles without a sample
  bool on_hold = false;
  bool force_oscillates = false;
  NetStatistics nets;
  ContactStatistics contacts;
  EnergyReport gain;  // energies at the largest gain relative to the energy at work

  /// Largest share of held cycles on a device; above it the run has the fault `held`, because the hand felt
  /// too little.
  static constexpr double max_held = 0.05;

  void add(const StageTimes& times) noexcept {
    for (std::size_t i = 0; i < times.size(); ++i) stage_ns[i].add(times[i]);
    compute_ns.add(compute_time(times));
  }
  const Histogram& step_ns() const noexcept { return stage_ns[static_cast<std::size_t>(Stage::step)]; }
  void add(const CycleRecord& record) noexcept {
    ++cycles;
    for (std::size_t i = 0; i < bodies.size(); ++i) bodies[i].add(record.bodies[i]);
    for (JointStatistics& joint : joints) joint.add(record.bodies[joint.child].joint_C);
    for (std::size_t i = 0; i < coordinates.size(); ++i) coordinates[i].add(record.joint_q[i], cycles == 1);
    for (std::size_t i = 0; i < drives.size(); ++i) drives[i].add(std::abs(record.drive_torque[i]));
    for (std::size_t i = 0; i < drive_energy.size(); ++i)
      drive_energy[i] = std::max(drive_energy[i], record.drive_energy[i]);
    if (record.engaged && !has(record.limited, Limited::ramp)) {
      following.add(record.following);
      sensing.add(record.sensing);
      exact_following.add(record.exact_following);
      encoders.add(record.encoders);
    }
    const std::uint32_t active = active_limits(record);
    for (std::size_t i = 0; i < run_limits.size(); ++i) limit_cycles[i] += active >> i & 1u;
    for (std::size_t i = 0; i < core_fault_texts.size(); ++i)
      fault_cycles[i] += has(record.fault, core_fault_texts[i].fault) ? 1 : 0;
    rig_faults = rig_faults | record.rig_faults;
    if (record.on_hold && !on_hold) ++holds;
    if (record.on_hold) ++hold_cycles;
    if (is_held(record)) ++held_cycles;
    on_hold = record.on_hold;
    if (record.energy.gained > gain_floor &&
        record.energy.gained * gain.at_work >= gain.gained * record.energy.at_work)
      gain = record.energy;
    force_oscillates = force_oscillates || record.force_oscillates;
    nets.add(record.nets, record.net_stretch);
    contacts.add(record.contacts);
  }
};

}  // namespace godobject
