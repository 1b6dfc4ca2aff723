// The study: cost and accuracy of the integrators, as CSV files, figures and a report.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/study/contact/cost.h"
#include "tests/study/contact/error.h"
#include "tests/study/contact/imposed.h"
#include "tests/study/contact/stability.h"
#include "tests/study/error_study.h"
#include "tests/study/extreme/study.h"
#include "tests/study/footprint_study.h"
#include "tests/study/joint/cost_study.h"
#include "tests/study/joint/study.h"
#include "tests/study/net/study.h"
#include "tests/study/random_study.h"
#include "tests/study/stability_study.h"

namespace godobject::study {

struct StudyOptions {
  bool error = true, stability = true, footprint = true, joints = true, contacts = true,
       nets = true;              // parts
  bool quick = false;            // small grids, well under a minute
  std::filesystem::path out;     // folder of the results; made if absent
  std::filesystem::path report;  // report.md to write; empty: none. Requires all parts.
  // Folder of the probe program and archives; empty: default_probe_directory().
  std::filesystem::path probe_directory;
  std::filesystem::path scene_directory;  // with lego.toml; empty: default_scene_directory()
  std::string machine;                    // for the report
  std::string command;                    // for the report
};

struct ExplicitLimit {
  double damping = 0, measured = 0;
};

struct StudyResults {
  std::vector<ErrorRow> errors;
  std::vector<RandomRow> random;
  std::vector<StabilityResult> stability;
  std::vector<ExplicitLimit> explicit_limits;
  std::vector<ExtremeMap> extremes;
  std::vector<FootprintRow> footprint;
  std::vector<JointRun> joint_drift, joint_stability;
  JointCosts joint_costs;
  ContactErrors contact_errors;
  std::vector<ContactStability> contact_stability;
  std::vector<PileRun> piles;
  std::vector<ContactCostRow> contact_costs;
  NetResults nets;
  double s3_reference_error = 0;   // m
  std::vector<std::string> notes;  // omitted parts, with the reason
};

/// Runs the parts, writes <part>.csv, <part>.gp, .png and .svg into `out`, and the report. Throws
/// std::runtime_error if a file cannot be written.
StudyResults run_study(const StudyOptions& options, const Progress& progress);

/// Returns the source folder of the shipped scenes.
std::filesystem::path default_scene_directory();

/// Returns compiler and flags of this build.
std::string build_description();

}  // namespace godobject::study
