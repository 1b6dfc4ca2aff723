// Recorded positions of the nodes of nets, as written by `run --nets`; traces do not contain them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "platform/scene/scene.h"

namespace godobject {

class NetRecording {
 public:
  NetRecording(std::vector<double> times, std::vector<float> nodes);

  /// Returns the positions at time t, s: linear between two rows, constant before the first and after the
  /// last.
  std::vector<Vec3> at(double t) const;
  double begin() const noexcept { return times_.front(); }
  double end() const noexcept { return times_.back(); }
  std::size_t num_rows() const noexcept { return times_.size(); }

 private:
  std::vector<double> times_;  // s, ascending; at least one
  std::vector<float> nodes_;   // row by row
};

struct NetRecordingResult {
  std::optional<NetRecording> nets;  // absent if there are errors
  std::vector<std::string> errors;
};
/// Reads the nets' file of a run of this scene.
NetRecordingResult read_nets(const std::string& path, const SceneConfig& scene);

}  // namespace godobject
