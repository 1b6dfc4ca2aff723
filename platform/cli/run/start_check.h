// How far the bodies are from their targets before anything moves, and how fast their targets are to move.
#pragma once

#include <string>
#include <vector>

#include "platform/session/session.h"

namespace godobject {

/// A body that begins far from the target that pulls it is flung there: a warning above 0.1 m or 0.5 rad, an error
/// above 1 m or 3 rad, where millimetres or degrees are the usual reason. Nothing on real buses, whose device
/// says only later where it is. `file`: what messages call the scene.
void check_start(const Session& session, const std::string& file, std::vector<std::string>& warnings,
                 std::vector<std::string>& errors);

/// Warns of a motion in which a target is faster than a hand. duration: of the run, s.
void check_speed(const SceneConfig& scene, const Motion& motion, double duration, const std::string& file,
                 std::vector<std::string>& warnings);

}  // namespace godobject
