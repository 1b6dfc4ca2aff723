// Stabilisation of joints on scene S3: drift with each stabilisation, by step and stiffness.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/study/error_study.h"

namespace godobject::study {

/// Returns integrator and stabilisation: those of core/joint/stabilisation.h with implicit Euler, then
/// at-prediction with tr-bdf2.
std::vector<std::string> joint_schemes();

/// Limits of a run; beyond them it fails. Joint violation of 0.1 m or 1 rad, or 100 times the largest kinetic
/// energy of the tool at its device.
inline constexpr double max_apart = 0.1;      // m
inline constexpr double max_apart_angle = 1;  // rad
inline constexpr double max_energy_ratio_of_device = 100;

struct JointRun {
  std::string scheme;
  double k = 0;  // N/m, of trocar and tube
  double h = 0;  // s
  bool failed = false;
  std::size_t steps = 0;  // until the failure
  Drift drift;            // largest, after every step; up to the failure
  Errors errors;          // drift study only: against the reference of S3
};

/// Runs every scheme at 4 to 0.25 ms, k = 1000 N/m, over 2 s.
std::vector<JointRun> study_drift(bool quick, const Progress& progress);

/// Map: by scheme, stiffness, step; the last varies fastest. All stiffnesses of S3 are scaled, damping ratios
/// kept. 1000 steps each.
struct JointGrid {
  std::vector<double> stiffnesses, steps;
};
JointGrid joint_grid(bool quick);
std::vector<JointRun> study_joint_stability(const JointGrid& grid, const Progress& progress);

void write_drift_csv(const std::filesystem::path& file, const std::vector<JointRun>& rows);
void write_joint_stability_csv(const std::filesystem::path& file, const std::vector<JointRun>& rows);

}  // namespace godobject::study
