// Instructions per step, counted by callgrind on the probe program (tests/study/probe).
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace godobject::study {

/// Returns the build's folder of the probe programs and archives.
std::filesystem::path default_probe_directory();
/// Returns the program in that folder with every composition, or with those of a quick study.
std::filesystem::path probe_program(const std::filesystem::path& probe_directory, bool quick);

class InstructionCounter {
 public:
  /// probe: path of the probe program.
  explicit InstructionCounter(std::filesystem::path probe);

  /// Returns the reason that counting is impossible; empty if it is possible.
  const std::string& why_not() const { return why_not_; }

  /// Returns the instructions per step of a composition on a motion of the probe at 1 ms. The default motion
  /// is that of S1 with one body. The result is (count of 2 n steps - count of n steps) / n; nullopt without
  /// valgrind or the probe.
  std::optional<double> per_step(const std::string& composition, const std::string& motion = "s1");

 private:
  std::optional<double> collected(const std::string& composition, const std::string& motion,
                                  std::size_t steps);

  std::filesystem::path probe_;
  std::string why_not_;
  std::map<std::string, std::optional<double>> known_;
};

}  // namespace godobject::study
