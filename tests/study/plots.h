// Figures of the study: one gnuplot script per figure, beside its CSV files, and the pictures.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/study/error_study.h"
#include "tests/study/footprint_study.h"
#include "tests/study/joint/study.h"
#include "tests/study/stability_study.h"

namespace godobject::study {

/// Opens DIR/<figure>.gp and writes the choice of format and size. width, height: pixels.
std::ofstream script(const std::filesystem::path& directory, const std::string& figure, int width,
                     int height);

/// Runs DIR/<figure>.gp twice, for DIR/<figure>.png and .svg. Returns the error; empty on success.
std::string draw(const std::filesystem::path& directory, const std::string& figure);

/// Each writes its script for the rows of the CSV file of the same part.
void write_error_script(const std::filesystem::path& directory, const std::vector<ErrorRow>& rows);
void write_stability_script(const std::filesystem::path& directory, std::size_t scheme_index,
                            const StabilityGrid& grid);
void write_drift_script(const std::filesystem::path& directory);
void write_joint_stability_script(const std::filesystem::path& directory, const JointGrid& grid);
void write_footprint_script(const std::filesystem::path& directory, const std::vector<FootprintRow>& rows);

}  // namespace godobject::study
