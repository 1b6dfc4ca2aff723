// A trace of a run as the motion of another: the devices' samples are replayed, not the bodies that followed them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "platform/scene/scene.h"
#include "platform/scene/text/csv.h"

namespace godobject {

/// True for a table that begins with the header of a trace.
bool is_trace(std::string_view csv);

/// The lines of a trace that are complete: a run that was killed leaves the last one without its end.
std::string_view whole_lines(std::string_view csv);

/// True for the columns of a trace of which a motion may be made.
bool is_of_motion(std::string_view column);

struct TraceMotion {
  std::optional<CsvTable> table;  // with the columns of a motion of this scene; absent where there are errors
  std::vector<std::string> errors;  // "file:1:1: what"
};
/// table: of a trace. The device's joints where it has them in every row, otherwise the hand's wrenches or the device's poses,
/// otherwise the targets; and engaged, clutch and held.
TraceMotion motion_of_trace(const CsvTable& table, const std::string& file, const SceneConfig& scene);

}  // namespace godobject
