// The paper's comparison: a brick that is placed at the device's pose (its Fig. 5) and one that is a god-object (Fig. 6),
// on the same motion of the scene lego.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "platform/scene/scene.h"
#include "tests/study/error_study.h"

namespace godobject::study {

/// A brick is ejected when it is ever outside the board, or faster than this.
inline constexpr double ejected_speed = 1;                       // m/s
inline constexpr double board_half_x = 0.4, board_half_y = 0.3;  // m
inline constexpr double board_depth = 0.02;                      // m, below it

/// At one time; peaks are those since the sample before.
struct PileSample {
  double t = 0;         // s
  double overlap = 0;   // m, depth of the deepest contact of all
  double force = 0;     // N, of the contacts on the brick that is held
  double energy = 0;    // J, kinetic and potential, of the bricks that are never held, more than at the start
  double residual = 0;  // N, of the contacts' solution
  std::size_t ejected = 0;  // bricks that are never held, so far
};

struct PileRun {
  std::string coupling;  // of coupling_names
  std::vector<PileSample> samples;
  PileSample worst;            // the largest of each
  std::size_t bricks = 0;      // that are never held
  std::size_t num_faults = 0;  // steps with a fault
};

/// lego.toml of the folder of scenes with both couplings: on lego-motion.csv, or quick on the scene's own motion for 2 s.
/// Throws std::runtime_error when they cannot be read.
std::vector<PileRun> study_imposed(const std::filesystem::path& scenes, bool quick, const Progress& progress);

/// One run of such a scene with that coupling; without a file its own motion, for `duration`.
PileRun run_pile(SceneConfig scene, CouplingMode coupling, const std::string& motion, double duration);

/// Every sample of both.
void write_csv(const std::filesystem::path& file, const std::vector<PileRun>& runs);

}  // namespace godobject::study
