// A figure: one gnuplot script beside its CSV files, and the pictures that it draws.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace godobject::study {

/// Opens DIR/<figure>.gp and writes the choice of format and size. width, height: pixels.
std::ofstream script(const std::filesystem::path& directory, const std::string& figure, int width,
                     int height);

/// Runs DIR/<figure>.gp twice, for DIR/<figure>.png and .svg. Returns the error; empty on success.
std::string draw(const std::filesystem::path& directory, const std::string& figure);

}  // namespace godobject::study
