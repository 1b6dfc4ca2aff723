#include "tests/study/instruction_count.h"

#include <sstream>

#include "tests/study/tool.h"

namespace godobject::study {

InstructionCounter::InstructionCounter(std::filesystem::path probe) : probe_(std::move(probe)) {
  if (!std::filesystem::exists(probe_))
    why_not_ = "the probe program is not built (target " + probe_.filename().string() + ")";
  else if (!tool_exists("valgrind")) why_not_ = "valgrind is not installed";
}

std::optional<double> InstructionCounter::per_step(const std::string& composition,
                                                   const std::string& motion) {
  if (!why_not_.empty()) return std::nullopt;
  const std::string key = composition + " on " + motion;
  if (const auto known = known_.find(key); known != known_.end()) return known->second;
  constexpr std::size_t n = 500;
  const std::optional<double> once = collected(composition, motion, n);
  const std::optional<double> twice = collected(composition, motion, 2 * n);
  std::optional<double> result;
  if (once && twice) result = (*twice - *once) / static_cast<double>(n);
  known_[key] = result;
  return result;
}

std::optional<double> InstructionCounter::collected(const std::string& composition, const std::string& motion,
                                                    std::size_t steps) {
  const ToolResult run = run_tool({"valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null",
                                   "--toggle-collect=*probe_step*", probe_.string(), composition,
                                   std::to_string(steps), motion});
  // line of callgrind: "==123== Collected : 45678"
  const std::string label = "Collected : ";
  const std::size_t at = run.output.find(label);
  if (!run.ok() || at == std::string::npos) return std::nullopt;
  double count = 0;
  if (!(std::istringstream(run.output.substr(at + label.size())) >> count)) return std::nullopt;
  return count;
}

std::filesystem::path default_probe_directory() { return GODOBJECT_PROBE_DIRECTORY; }
std::filesystem::path probe_program(const std::filesystem::path& probe_directory, bool quick) {
  return probe_directory / (quick ? "godobject_quick_probe" : "godobject_probe");
}

}  // namespace godobject::study
