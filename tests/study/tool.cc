#include "tests/study/tool.h"

#include <sys/wait.h>

#include <array>
#include <cstdio>

namespace godobject::study {
namespace {

/// Quotes an argument such that the shell reads it unchanged.
std::string quoted(const std::string& argument) {
  std::string result = "'";
  for (const char c : argument) {
    if (c == '\'') result += "'\\''";
    else result += c;
  }
  return result + "'";
}

}  // namespace

ToolResult run_tool(const std::vector<std::string>& arguments) {
  std::string command;
  for (const std::string& argument : arguments) command += quoted(argument) + ' ';
  ToolResult result;
  std::FILE* const pipe = ::popen((command + "2>&1").c_str(), "r");
  if (pipe == nullptr) return result;
  std::array<char, 4096> chunk{};
  for (std::size_t n = 0; (n = std::fread(chunk.data(), 1, chunk.size(), pipe)) > 0;)
    result.output.append(chunk.data(), n);
  const int status = ::pclose(pipe);
  result.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

bool tool_exists(const std::string& program) { return run_tool({program, "--version"}).ok(); }

}  // namespace godobject::study
