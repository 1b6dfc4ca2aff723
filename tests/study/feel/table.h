// Tables of the impedance that a hand feels, as Markdown.
#pragma once

#include <string>
#include <vector>

#include "tests/study/feel/feel.h"

namespace godobject::study {

/// Measurements of a case over all frequencies.
struct FeelSweep {
  FeelCase of;
  std::vector<Felt> felt;
};

/// Measures each plan, integrator and damping ratio, free and then pressed. per_decade: see
/// feel_frequencies().
std::vector<FeelSweep> sweep_feel(int per_decade);

/// Returns two tables. The first has the displayed impedance of each plan, integrator and damping ratio. The
/// second has, for each plan on buses, the impedance at the hand with the device's own mechanics, and the
/// frequencies at which counts dominate. sweeps: of sweep_feel().
std::string feel_tables(const std::vector<FeelSweep>& sweeps);

}  // namespace godobject::study
