// The solution a scene's runs are set against.
#pragma once

#include "tests/oracle/solve.h"
#include "tests/study/reference_scene.h"

namespace godobject::study {

/// At multiples of 4 ms: the oracle's, or of a stiff scene that of tr-bdf2 at 1/64 ms.
oracle::Solution reference_of(const ReferenceScene& scene);

/// How far the reference of a stiff scene is from the oracle in its first 0.05 s, m, of the worst body.
double reference_error(const ReferenceScene& scene);

}  // namespace godobject::study
