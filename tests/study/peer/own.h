// The core's rows of the comparison with its peers.
#pragma once

#include <vector>

#include "tests/study/peer/study.h"

namespace godobject::study {

/// scenes: S1 first.
std::vector<PeerError> own_errors(const std::vector<ReferenceScene>& scenes, bool quick,
                                  const Progress& progress);
std::vector<PeerContact> own_contacts(const std::vector<double>& stiffnesses);
PeerPile own_pile();
PeerNet own_net();
std::vector<PeerStability> own_stability(const std::vector<double>& stiffnesses,
                                         const std::vector<double>& steps, double duration);

}  // namespace godobject::study
