// Comparison of the paper on the same motions of the scene lego: a brick placed at the device's pose (Fig.
// 5), and a brick as a god-object (Fig. 6).
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "platform/scene/scene.h"
#include "tests/study/error_study.h"

namespace godobject::study {

/// A brick is ejected if it is outside the board, or faster than this, at any time.
inline constexpr double ejected_speed = 1;                       // m/s
inline constexpr double board_half_x = 0.4, board_half_y = 0.3;  // m
inline constexpr double board_depth = 0.02;                      // m, depth below the board

/// State at one time; peaks are those since the previous sample.
struct PileSample {
  double t = 0;         // s
  double overlap = 0;   // m, depth of the deepest contact
  double force = 0;     // N, of the contacts on the held brick
  double energy = 0;    // J, kinetic and potential, of the bricks that are never held, relative to the start
  double residual = 0;  // N, residual of the contact solution
  std::size_t ejected = 0;  // number of ejected bricks that are never held, so far
};

struct PileRun {
  std::string coupling;  // one of coupling_names; `... plunging` on the motion of plunge.csv
  std::vector<PileSample> samples;
  PileSample worst;            // largest of each value
  std::size_t bricks = 0;      // number of bricks that are never held
  std::size_t num_faults = 0;  // number of steps with a fault
};

/// Returns the modes of a brick as a god-object and of a placed one.
std::array<CouplingMode, 2> both_couplings();

/// The device goes 30 mm into the pile within 10 ms, at less than 5 m/s.
std::string plunge_motion();
inline constexpr double plunge_duration = 1.01;  // s

/// Runs lego.toml of the folder of scenes with both couplings: on lego-motion.csv, or if quick on the scene's
/// own motion for 2 s. Runs both again on plunge_motion(). Throws std::runtime_error if a file cannot be
/// read.
std::vector<PileRun> study_imposed(const std::filesystem::path& scenes, bool quick, const Progress& progress);

/// Runs such a scene once with this coupling. motion: file; empty: the scene's own motion, for `duration` s.
PileRun run_pile(SceneConfig scene, CouplingMode coupling, const std::string& motion, double duration);

/// Writes every sample of both runs.
void write_csv(const std::filesystem::path& file, const std::vector<PileRun>& runs);

}  // namespace godobject::study
