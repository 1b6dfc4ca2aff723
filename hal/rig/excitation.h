// Moves the joints of a rig one after the other by slow sines, and records torque and motion for
// hal/rig/identification.h.
#pragma once

#include <string>
#include <vector>

#include "hal/rig/identification.h"
#include "hal/rig/rig.h"
#include "hal/rig/simulation.h"

namespace godobject {

struct ExcitationParams {
  std::vector<std::size_t> joints;  // moved joints, in this order
  std::vector<double> amplitude;    // of each, rad or m
  double period_s = 2;              // of the slow sine; the fast one has a quarter of it and of the amplitude
  int cycles = 3;                   // of the slow sine; the fast one lasts half as long
  double torque = 0.5;              // share of the drives' torque_max_Nm that may be used
};

/// Steps of a run. A spring and a damper pull each joint to its reference, and an integral carries the links,
/// within the share of the drives' torque. A joint that leaves its range or is too fast ends the run.
class Excitation {
 public:
  /// Returns the reasons why this rig cannot be excited; empty if it can.
  static std::vector<std::string> complaints(const RigParams& rig, const ExcitationParams& params);

  /// complaints() must be empty. rig: valid, outlives this object. plant: the inertias bound the stiffness of
  /// the hold. step_s: period, s. Allocates for the whole record; step() does not.
  Excitation(const RigParams& rig, const PlantConfig& plant, double step_s, ExcitationParams params);

  /// One step of the run, between read() and command() of the rig. Returns false after the last.
  /// q: joint coordinates of the rig's sample. valid: true if the sample is valid.
  /// F_hand_W: receives a wrench for each handle, whose joint torques are those wanted.
  bool step(const Rig& rig, const JointVector& q, bool valid, std::span<Wrench> F_hand_W) noexcept;

  /// Duration of the whole run, s.
  double duration_s() const noexcept;
  /// Returns the largest speed of the reference of the present joint, rad/s or m/s.
  double peak_speed() const noexcept;
  bool finished() const noexcept { return at_ >= records_.size(); }
  /// Returns the reason why it gave up; empty if it did not. Allocates.
  std::string why_not() const;
  const std::vector<JointExcitation>& records() const noexcept { return records_; }

 private:
  struct Axis {
    std::size_t drive = 0;
    double joint_per_motor = 1;         // torque of the joint for one of the motor
    double stiffness = 0, damping = 0;  // of the hold, N m/rad or N/m, and N m s/rad or N s/m
    double bound = 0;                   // of the torque, N m or N
    double range = 0, max_speed = 0;    // beyond: gives up; rad or m, and per s
    double integral = 0;                // torque, N m or N
  };
  enum class Ending : std::uint8_t { none, out_of_range, too_fast };

  void record(const Rig& rig, const JointVector& q) noexcept;
  bool too_far(const JointVector& q, const JointVector& q_dot) noexcept;
  JointTarget reference() const noexcept;
  double slow_s() const noexcept;    // duration of the slow sine of a joint, s
  double moving_s() const noexcept;  // of both sines, s
  double joint_s() const noexcept;   // of a joint with its rests, s
  double time_s() const noexcept;    // since the slow sine of the present joint began, s
  std::size_t steps(double s) const noexcept;

  const RigParams& rig_;
  double step_s_;
  ExcitationParams params_;
  KinematicTree tree_;
  std::vector<Axis> axes_;  // by joint
  std::vector<JointExcitation> records_;
  std::size_t at_ = 0;    // excited joint
  std::size_t step_ = 0;  // since it began
  JointVector q_0_, q_before_, q_dot_;
  Ending ending_ = Ending::none;
  std::size_t ended_by_ = 0;  // joint
};

}  // namespace godobject
