// Maps of what stiff and extreme cases may do in silence: gain energy, or never come to rest. Each cell is the worst of some
// cases drawn at random; it is red where its worst is beyond the map's limit.
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
  double worst = 0;  // in the map's unit; infinite for a fault
  unsigned worst_draw = 0;
};

struct ExtremeMap {
  std::string name;     // of its files
  std::string about;    // one line
  std::string measure;  // what a cell says, with its unit
  double limit = 0;
  Axis panels, rows, columns;
  unsigned draws = 0;                   // cases of a cell
  std::vector<ExtremeCell> cells = {};  // by integrator, panel, row, column, the last the quickest

  bool is_red(const ExtremeCell& cell) const { return !(cell.worst <= limit); }
};

/// A case of a cell: its measure, from what is drawn with the seed.
using ExtremeCase = std::function<double(double panel, double row, double column, unsigned seed)>;

/// Runs all cells with one integrator.
void fill(ExtremeMap& map, const std::string& integrator, const ExtremeCase& measure,
          const Progress& progress);

/// Free and weakly coupled rods that spin: gain over the first energy. Rate x slenderness.
ExtremeMap map_spin(bool quick, const Progress& progress);
/// Chains of 2 to 5 links released with a heavy last one: gain over the most kinetic energy. Mass ratio x step.
ExtremeMap map_heavy_end(bool quick, const Progress& progress);
/// Trees of joints whose targets contradict them: speed after 3.6 s. Stiffness x how far targets are off.
ExtremeMap map_contradiction(bool quick, const Progress& progress);
/// A box pressed on a plane: speed after 3 s. Contact stiffness x coupling, a panel for each step.
ExtremeMap map_pressed(bool quick, const Progress& progress);
/// Nets through all ordeals of the tests: gain over the energy at work. Springs x node mass, a panel for each step.
ExtremeMap map_nets(bool quick, const Progress& progress);

std::vector<ExtremeMap> study_extremes(bool quick, const Progress& progress);

/// <name>.csv and <name>.gp of a map.
void write_csv(const std::filesystem::path& file, const ExtremeMap& map);
void write_extreme_script(const std::filesystem::path& directory, const ExtremeMap& map);
/// "extreme-<name>": of the files of a map.
std::string figure_of(const ExtremeMap& map);

}  // namespace godobject::study
