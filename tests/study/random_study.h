// Comparison of the error study with random parameters. Results are the ratio of errors, tr-bdf2 at 1 ms over
// implicit-euler at 0.125 ms, and the share of scenes with a ratio of at most one.
#pragma once

#include "tests/study/error_study.h"

namespace godobject::study {

/// Error of tr-bdf2 at 1 ms over that of implicit-euler at 0.125 ms.
struct RandomRow {
  std::string scene;
  unsigned seed = 0;
  double position = 0, rotation = 0;  // ratios
};

/// Returns a random scene of a kind: "released" (a rod released towards a resting target, as coupling-step),
/// "led" (a rod on a moving target, as S1). "chain" has 2 to 5 links with a heavier last one, as chain-5;
/// "top" is a fast top on a ball joint, as heavy-top.
ReferenceScene random_scene(const std::string& kind, unsigned seed);
std::vector<std::string> random_kinds();

/// Compares with tr-bdf2 at 1/64 ms.
std::vector<RandomRow> study_random(bool quick, const Progress& progress);

void write_csv(const std::filesystem::path& file, const std::vector<RandomRow>& rows);

}  // namespace godobject::study
