// Reference solution for the runs of a scene.
#pragma once

#include "tests/oracle/solve.h"
#include "tests/study/reference_scene.h"

namespace godobject::study {

/// Returns the reference at multiples of 4 ms: the oracle's; for a stiff scene that of tr-bdf2 at 1/64 ms.
oracle::Solution reference_of(const ReferenceScene& scene);

/// Returns the largest distance of a stiff scene's reference from the oracle in its first 0.05 s, m, over all
/// bodies.
double reference_error(const ReferenceScene& scene);

}  // namespace godobject::study
