// Maps of undetected failures in stiff and extreme cases: energy gain, or motion that does not come to rest.
// Each cell is the worst of several random cases; it is red if its worst value exceeds the map's limit.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/study/error_study.h"

namespace godobject::study {

struct Axis {
  std::string label;  // with its unit
  std::vector<double> values;
};

struct ExtremeCell {
  std::string integrator;
  double panel = 0, row = 0, column = 0;
  double worst = 0;  // in the unit of the map; infinite for a fault
  unsigned worst_draw = 0;
};

struct ExtremeMap {
  std::string name;     // name of its files
  std::string about;    // one line
  std::string measure;  // value of a cell, with its unit
  double limit = 0;
  Axis panels, rows, columns;
  unsigned draws = 0;                   // cases per cell
  std::vector<ExtremeCell> cells = {};  // by integrator, panel, row, column; the last varies fastest

  bool is_red(const ExtremeCell& cell) const { return !(cell.worst <= limit); }
};

/// Returns the measure of a random case of a cell. seed: determines the random parameters.
using ExtremeCase = std::function<double(double panel, double row, double column, unsigned seed)>;

/// Runs all cells with one integrator.
void fill(ExtremeMap& map, const std::string& integrator, const ExtremeCase& measure,
          const Progress& progress);

/// Spinning rods, free or weakly coupled: gain over the initial energy. Rate x slenderness.
ExtremeMap map_spin(bool quick, const Progress& progress);
/// Chains of 2 to 5 links released with a heavy last one: gain over the largest kinetic energy. Mass ratio x
/// step.
ExtremeMap map_heavy_end(bool quick, const Progress& progress);
/// Trees of joints with contradictory targets: speed after 3.6 s. Stiffness x displacement of the targets.
ExtremeMap map_contradiction(bool quick, const Progress& progress);
/// A box pressed on a plane: speed after 3 s. Contact stiffness x coupling, one panel per step.
ExtremeMap map_pressed(bool quick, const Progress& progress);
/// Nets in all cases of the tests: gain over the energy at work. Springs x node mass, one panel per step.
ExtremeMap map_nets(bool quick, const Progress& progress);

std::vector<ExtremeMap> study_extremes(bool quick, const Progress& progress);

/// Writes <name>.csv and <name>.gp of a map.
void write_csv(const std::filesystem::path& file, const ExtremeMap& map);
void write_extreme_script(const std::filesystem::path& directory, const ExtremeMap& map);
/// Returns "extreme-<name>", the base name of a map's files.
std::string figure_of(const ExtremeMap& map);

}  // namespace godobject::study
