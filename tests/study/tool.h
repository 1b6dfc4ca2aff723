// Programs the study uses when they are installed: gnuplot, valgrind, size.
#pragma once

#include <string>
#include <vector>

namespace godobject::study {

struct ToolResult {
  int status = -1;     // exit status; 127 where there is no such program, -1 where it could not be started
  std::string output;  // standard output and standard error

  bool ok() const { return status == 0; }
};

/// Runs a program found on PATH and waits for it.
ToolResult run_tool(const std::vector<std::string>& arguments);

bool tool_exists(const std::string& program);

}  // namespace godobject::study
