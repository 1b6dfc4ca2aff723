// Runs in wall time on a machine that may be busy.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "tests/support/program.h"

namespace godobject::test {

/// Runs `godobject run <arguments>` with a report at `path`, again if a busy machine has held the pose.
/// Returns the report, which is no object if there is none.
inline nlohmann::json run_unless_held(const std::string& arguments, const std::string& path,
                                      ProgramResult& result) {
  nlohmann::json report;
  for (int attempt = 0; attempt < 10; ++attempt) {
    result = run_program("run " + arguments + " --report " + path);
    report = nlohmann::json::parse(read_file(path), nullptr, false);
    if (!report.is_object() || !report["limits"].contains("deadlines")) break;
  }
  return report;
}

}  // namespace godobject::test
