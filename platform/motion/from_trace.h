// Converts the trace of a run into the motion of another, from the devices' samples, not from the bodies that
// followed them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "platform/scene/scene.h"
#include "platform/scene/text/csv.h"

namespace godobject {

/// True for a table with the header of a trace.
bool is_trace(std::string_view csv);

/// Returns the complete lines of a trace; the last line of a killed run has no end.
std::string_view whole_lines(std::string_view csv);

/// True for the columns of a trace that a motion can use.
bool is_of_motion(std::string_view column);

struct TraceMotion {
  // table with the columns of a motion of this scene; absent if there are errors
  std::optional<CsvTable> table;
  std::vector<std::string> errors;  // "file:1:1: text"
};
/// Converts a trace. Uses the rows with the device's joints if there are any, else the hand's wrenches or the
/// device's poses, else the targets. Adds engaged, clutch and held.
/// table: table of the trace.
TraceMotion motion_of_trace(const CsvTable& table, const std::string& file, const SceneConfig& scene);

}  // namespace godobject
