// Error against run time of each integrator on the reference scenes.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/study/case_errors.h"
#include "tests/study/instruction_count.h"

namespace godobject::study {

using Progress = std::function<void(const std::string& line)>;

struct ErrorRow {
  std::string scene;
  std::string integrator;
  double h = 0;  // s
  Errors errors;
  std::optional<double> order_position;  // log2 of the error at 2 h over the error at h
  std::optional<double> order_rotation;
  double ns_per_step = 0;  // per step, median
  std::optional<double> instructions_per_step;

  double ns_per_second() const { return ns_per_step / h; }  // per simulated second
  std::optional<double> instructions_per_second() const;
};

/// Returns the steps, s, each half of the previous one; the longest determines the comparison times.
std::vector<double> error_steps(bool quick);

/// Runs every scene with every integrator and step.
std::vector<ErrorRow> study_error(const std::vector<ReferenceScene>& scenes, bool quick,
                                  InstructionCounter& counter, const Progress& progress);

/// Returns the errors of one integrator ("implicit-euler", "tr-bdf2") on one scene. Throws std::runtime_error
/// for a fault.
Errors measure_errors(const ReferenceScene& scene, const std::string& integrator, double h);

void write_csv(const std::filesystem::path& file, const std::vector<ErrorRow>& rows);

}  // namespace godobject::study
