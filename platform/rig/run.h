// Runs a user's step on the rig that a scene file describes, as `godobject run --bus` runs its engine's step.
// For programs with a scene in code. Commands motors, and removes their torque whenever it ends.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "platform/device/rig.h"
#include "platform/rig/buses.h"

namespace godobject {

class RigRun {
 public:
  /// Reads and checks the scene and opens its buses; sends no frame. See errors().
  /// Closed descriptors 0 to 2 are opened on /dev/null, so that no bus becomes standard error.
  /// scene_file: a scene with a device on buses. addresses: as for rig_addresses().
  RigRun(const std::string& scene_file, std::span<const std::string> addresses);
  RigRun(const RigRun&) = delete;  // device_ refers to scene_
  RigRun& operator=(const RigRun&) = delete;

  /// Errors, one line each: subject, place, remedy. If not empty, step_s() and run() must not be called.
  const std::vector<std::string>& errors() const noexcept { return errors_; }
  /// Step of the scene, s.
  double step_s() const noexcept { return scene_.step; }
  const SceneConfig& scene() const noexcept { return scene_; }
  /// The device, for the step: joints and commanded torques.
  const RigDevice& device() const noexcept { return *device_; }

  /// One step on the real-time thread. Returns false if it was the last.
  /// First argument: samples of the scene's bodies at the end of the step.
  /// F_hand_W: wrenches to display on the hand, N and N m, one per body, zero on entry.
  using Step = std::function<bool(std::span<const BodySample>, std::span<Wrench> F_hand_W)>;

  struct Result {
    std::uint64_t steps = 0;
    std::uint64_t missed_deadlines = 0;
    std::string why_not;  // if no step was made: one line for each reason
    std::string faults;   // faults of the rig, one line each
    std::string signal;   // signal that ended the run
    bool is_good() const noexcept { return steps > 0 && faults.empty(); }
  };
  /// Runs the rig in this thread; to be called once. Sets up the nodes, boots, steps once a period, and
  /// finally runs the torque down and switches the drives off.
  /// The last step, a fault and a signal end the run; drives are switched off also if the program dies. Many
  /// missed deadlines make the samples invalid, too many in a row end the run.
  Result run(const Step& step);

 private:
  SceneConfig scene_;
  std::vector<std::string> errors_;
  RigAddresses where_;
  RigProfiles profiles_;
  LinuxLink* link_ = nullptr;  // owned by device_
  std::unique_ptr<RigDevice> device_;
};

}  // namespace godobject
