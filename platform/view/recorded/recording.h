// Recordings as frames: a trace of a scene, or only the start of the scene.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "platform/scene/scene.h"
#include "platform/view/recorded/nets.h"
#include "platform/view/scene_json.h"
#include "platform/view/server/server.h"
#include "platform/view/tap.h"

namespace godobject {

/// Displayed instants of a trace.
struct Recording {
  SceneConfig scene;
  std::vector<ViewSample> samples;     // at least one, in the order of time
  std::optional<NetRecording> nets{};  // absent: positions of nodes were not recorded
};

/// Returns the positions of the nodes, world, m: those of the sample, of the recorded nets, or else the
/// nodes' anchors.
std::vector<Vec3> nodes_of(const Recording& recording, const SceneNets& nets, const ViewSample& sample);

/// Highest rate of a page's instants, per second, and their largest number; instants between them are left
/// out.
inline constexpr double recorded_rate_hz = 100;
inline constexpr std::size_t max_recorded = 20000;
/// Limit on the bytes of nodes for a page; further instants are left out.
inline constexpr std::size_t max_recorded_net_bytes = std::size_t{256} << 20;

/// Returns the start of the scene as a recording.
Recording recording_of(const SceneConfig& scene);

struct RecordingResult {
  std::optional<Recording> recording;  // absent if there are errors
  std::vector<std::string> errors, notes{};
};
/// Reads a trace that `run --trace` wrote of this scene.
RecordingResult read_trace(const std::string& path, const SceneConfig& scene);

/// Returns the sample nearest to time t, s; without t the last one.
const ViewSample& sample_at(const Recording& recording, std::optional<double> t);

/// A recording as the source of pages.
class RecordedView final : public ViewSource {
 public:
  RecordedView(const Recording& recording, const ViewAbout& about);

  std::string scene() override { return scene_; }
  ViewBytes recording() override { return frames_; }

 private:
  std::string scene_;
  ViewBytes frames_;
};

}  // namespace godobject
