// Figures of the study: one gnuplot script per figure, beside its CSV files, and the pictures.
#pragma once

#include <filesystem>
#include <vector>

#include "tests/study/error_study.h"
#include "tests/study/figure.h"
#include "tests/study/footprint_study.h"
#include "tests/study/joint/study.h"
#include "tests/study/stability_study.h"

namespace godobject::study {

/// Each writes its script for the rows of the CSV file of the same part.
void write_error_script(const std::filesystem::path& directory, const std::vector<ErrorRow>& rows);
void write_stability_script(const std::filesystem::path& directory, std::size_t scheme_index,
                            const StabilityGrid& grid);
void write_drift_script(const std::filesystem::path& directory);
void write_joint_stability_script(const std::filesystem::path& directory, const JointGrid& grid);
void write_footprint_script(const std::filesystem::path& directory, const std::vector<FootprintRow>& rows);

}  // namespace godobject::study
