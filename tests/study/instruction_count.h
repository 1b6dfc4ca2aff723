// Instructions of one step, counted by callgrind on the probe program (tests/study/probe).
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace godobject::study {

/// Where the build puts the probe programs and the archives.
std::filesystem::path default_probe_directory();
/// The program with every composition in such a folder, or that with those of a quick study.
std::filesystem::path probe_program(const std::filesystem::path& probe_directory, bool quick);

class InstructionCounter {
 public:
  /// `probe`: the probe program.
  explicit InstructionCounter(std::filesystem::path probe);

  /// Why nothing can be counted; empty when it can.
  const std::string& why_not() const { return why_not_; }

  /// Instructions of one step of a composition on a motion of the probe at 1 ms, by default that of S1 with one body:
  /// (count of 2 n steps - count of n steps) / n. Nothing where valgrind or the probe is missing.
  std::optional<double> per_step(const std::string& composition, const std::string& motion = "s1");

 private:
  std::optional<double> collected(const std::string& composition, const std::string& motion,
                                  std::size_t steps);

  std::filesystem::path probe_;
  std::string why_not_;
  std::map<std::string, std::optional<double>> known_;
};

}  // namespace godobject::study
