// What holds joints together, on scene S3: how far they come apart with each stabilisation, by step and by stiffness.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/study/error_study.h"

namespace godobject::study {

/// Integrator and stabilisation: those of core/joint/stabilisation.h with implicit Euler, then at-prediction with tr-bdf2.
std::vector<std::string> joint_schemes();

/// A run fails by a fault, by a joint apart by more than 0.1 m or 1 rad, or by 100 times the largest kinetic energy
/// the tool has on its device.
inline constexpr double max_apart = 0.1;      // m
inline constexpr double max_apart_angle = 1;  // rad
inline constexpr double max_energy_ratio_of_device = 100;

struct JointRun {
  std::string scheme;
  double k = 0;  // N/m, of trocar and tube
  double h = 0;  // s
  bool failed = false;
  std::size_t steps = 0;  // until it failed
  Drift drift;            // worst, after every step; up to the failure
  Errors errors;          // of the drift study: against the reference of S3
};

/// At k = 1000 N/m, over 2 s: every scheme at 4 to 0.25 ms.
std::vector<JointRun> study_drift(bool quick, const Progress& progress);

/// Rows of the map: scheme, then stiffness, then step, the last the quickest. All stiffnesses of S3 rise together,
/// damping ratios stay. 1000 steps each.
struct JointGrid {
  std::vector<double> stiffnesses, steps;
};
JointGrid joint_grid(bool quick);
std::vector<JointRun> study_joint_stability(const JointGrid& grid, const Progress& progress);

void write_drift_csv(const std::filesystem::path& file, const std::vector<JointRun>& rows);
void write_joint_stability_csv(const std::filesystem::path& file, const std::vector<JointRun>& rows);

}  // namespace godobject::study
