// Programs that the study uses if installed: gnuplot, valgrind, size.
#pragma once

#include <string>
#include <vector>

namespace godobject::study {

struct ToolResult {
  int status = -1;     // exit status; 127: no such program; -1: not started
  std::string output;  // standard output and standard error

  bool ok() const { return status == 0; }
};

/// Runs a program found on PATH and waits for its end.
ToolResult run_tool(const std::vector<std::string>& arguments);

bool tool_exists(const std::string& program);

}  // namespace godobject::study
