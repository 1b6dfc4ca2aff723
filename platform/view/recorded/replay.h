// Recomputes a recording from logs of buses: rig and core process the frames at the times of the log.
#pragma once

#include <string>

#include "platform/view/recorded/recording.h"

namespace godobject {

/// Replays a log. log: file of `run --record` with all buses of the scene. scene_path: file of the scene, for
/// profiles beside it.
RecordingResult replay_log(const std::string& log, const std::string& scene_path, const SceneConfig& scene);

}  // namespace godobject
