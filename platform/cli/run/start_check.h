// Distance of the bodies from their targets at the start, and speed of their targets.
#pragma once

#include <string>
#include <vector>

#include "platform/session/session.h"

namespace godobject {

/// Checks the distance of each body from its target at the start, since the coupling would fling it there.
/// Warns above 0.1 m or 0.5 rad; fails above 1 m or 3 rad, of which millimetres or degrees are the usual
/// cause. Does nothing on real buses, whose device reports its pose later.
/// file: name of the scene in messages.
void check_start(const Session& session, const std::string& file, std::vector<std::string>& warnings,
                 std::vector<std::string>& errors);

/// Warns of a motion whose target is faster than a hand.
/// duration: duration of the run, s.
void check_speed(const SceneConfig& scene, const Motion& motion, double duration, const std::string& file,
                 std::vector<std::string>& warnings);

}  // namespace godobject
