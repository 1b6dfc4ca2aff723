// The native peers of tests/bench/peer on the scenes of the comparison.
#pragma once

#include <vector>

#include "tests/study/peer/study.h"
#include "tests/study/peer/timed.h"

namespace godobject::study {

/// Returns the errors of the native peers, without times.
std::vector<PeerError> native_errors(const std::vector<ReferenceScene>& scenes,
                                     const std::vector<double>& steps, const Progress& progress);

/// Adds the native times to all rows of the core's integrators and of native peers that have not failed.
void add_native_times(const std::vector<ReferenceScene>& scenes, bool quick, const Progress& progress,
                      std::vector<PeerError>& rows);

Runs<PeerContact> native_contacts(const std::vector<double>& stiffnesses);
Runs<PeerPile> native_piles();
Runs<PeerNet> native_nets();
std::vector<PeerStability> native_stability(const std::vector<double>& stiffnesses,
                                            const std::vector<double>& steps, double duration);

}  // namespace godobject::study
