// The scenes of the benchmarks with their references, made once each.
#pragma once

#include "tests/oracle/solve.h"
#include "tests/study/reference_scene.h"

namespace godobject::bench {

struct BenchScene {
  study::ReferenceScene scene;
  oracle::Solution reference;  // may end before the scene
};

/// 20 s; errors from 0.5 s on, against the oracle.
const BenchScene& s1();
/// 10 s; errors from 0.5 s on, against tr-bdf2 at 1/64 ms.
const BenchScene& s3();
/// 2 s of 1, 8, 64 or 256 links; errors of the first half second (it is chaotic later), against tr-bdf2 at
/// 1/32 ms.
const BenchScene& s5(std::size_t num_links);

}  // namespace godobject::bench
