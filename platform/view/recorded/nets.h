// Where the nodes of nets were, as `run --nets` writes it: a trace has none of them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "platform/scene/scene.h"

namespace godobject {

class NetRecording {
 public:
  NetRecording(std::vector<double> times, std::vector<float> nodes);

  /// At this time, s: between two rows as if each node went straight, before the first and after the last as there.
  std::vector<Vec3> at(double t) const;
  double begin() const noexcept { return times_.front(); }
  double end() const noexcept { return times_.back(); }
  std::size_t num_rows() const noexcept { return times_.size(); }

 private:
  std::vector<double> times_;  // s, rising; at least one
  std::vector<float> nodes_;   // row by row
};

struct NetRecordingResult {
  std::optional<NetRecording> nets;  // absent where there are errors
  std::vector<std::string> errors;
};
/// What a run of this scene has written.
NetRecordingResult read_nets(const std::string& path, const SceneConfig& scene);

}  // namespace godobject
