// A step of one's own on the rig that a scene file describes: what `godobject run --bus` does around its engine's step, for a
// program that has its scene in code. It commands motors; whatever ends it takes the torque away.
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
  /// Closed descriptors 0 to 2 are opened on /dev/null, so that no bus becomes standard error.
  /// scene_file: with a device on buses. addresses: as rig_addresses(). Reads, checks and opens; nothing is sent yet. See
  /// errors().
  RigRun(const std::string& scene_file, std::span<const std::string> addresses);

  /// Each a line: what, where, what to do. Not empty: step_s() and run() are not to be called.
  const std::vector<std::string>& errors() const noexcept { return errors_; }
  /// The scene's, s.
  double step_s() const noexcept { return scene_.step; }

  /// One step, on the real-time thread: the samples of the scene's bodies at its end, and the wrench on the hand that each is
  /// to show (zero before). False: it was the last.
  using Step = std::function<bool(std::span<const BodySample>, std::span<Wrench> F_hand_W)>;

  struct Result {
    std::uint64_t steps = 0;
    std::uint64_t missed_deadlines = 0;
    std::string why_not;  // it never came to a step: a line for each reason
    std::string faults;   // of the rig, a line each
    std::string signal;   // that ended it
    bool is_good() const noexcept { return steps > 0 && faults.empty(); }
  };
  /// In this thread, once: sets the nodes up, boots, steps once a period, runs the torque down at the last step, at a fault and at
  /// a signal, and switches the drives off, also when the program dies. Many missed deadlines hold the samples, too many in a row
  /// end it.
  Result run(const Step& step);

 private:
  SceneConfig scene_;
  std::vector<std::string> errors_;
  RigAddresses where_;
  RigProfiles profiles_;
  LinuxLink* link_ = nullptr;  // the device's
  std::unique_ptr<RigDevice> device_;
};

}  // namespace godobject
