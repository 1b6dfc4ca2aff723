// What was recorded, as frames: a trace of a scene, or the scene alone as it begins.
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

/// The instants of a trace that are shown.
struct Recording {
  SceneConfig scene;
  std::vector<ViewSample> samples;     // at least one, in the order of time
  std::optional<NetRecording> nets{};  // absent: nobody has written where the nodes were
};

/// Where the nodes are, in the world, m: as the sample says, or the recording of nets; on their anchors where neither does.
std::vector<Vec3> nodes_of(const Recording& recording, const SceneNets& nets, const ViewSample& sample);

/// A page plays so many instants a second, or fewer, and gets so many at most; what lies between them is left out.
inline constexpr double recorded_rate_hz = 100;
inline constexpr std::size_t max_recorded = 20000;
/// A page gets so many bytes of nodes at most; what lies between the instants is left out likewise.
inline constexpr std::size_t max_recorded_net_bytes = std::size_t{256} << 20;

/// The scene as it begins.
Recording recording_of(const SceneConfig& scene);

struct RecordingResult {
  std::optional<Recording> recording;  // absent where there are errors
  std::vector<std::string> errors, notes{};
};
/// A trace that `run --trace` has written of this scene.
RecordingResult read_trace(const std::string& path, const SceneConfig& scene);

/// The sample nearest to this time; none given: the last.
const ViewSample& sample_at(const Recording& recording, std::optional<double> t);

/// For pages.
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
