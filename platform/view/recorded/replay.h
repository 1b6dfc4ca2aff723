// A recording of buses made into a trace again: the rig and the core work on the frames, by the times in the log.
#pragma once

#include <string>

#include "platform/view/recorded/recording.h"

namespace godobject {

/// log: of `run --record`, of all buses of the scene. scene_path: of its file, for profiles beside it.
RecordingResult replay_log(const std::string& log, const std::string& scene_path, const SceneConfig& scene);

}  // namespace godobject
