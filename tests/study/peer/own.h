// The core's rows of the comparison with its peers.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/bench/contact_quality.h"
#include "tests/study/peer/bag.h"
#include "tests/study/peer/study.h"
#include "tests/study/peer/timed.h"

namespace godobject::study {

/// scenes: S1 first.
std::vector<PeerError> own_errors(const std::vector<ReferenceScene>& scenes, bool quick,
                                  const Progress& progress);
Runs<PeerContact> own_contacts(const std::vector<double>& stiffnesses);
PeerPile own_pile();
/// Returns the row of a native pile.
PeerPile pile_row(const std::string& engine, const bench::ContactQuality& quality, const StepClock& clock,
                  bool failed);
Runs<PeerNet> own_nets();
/// Returns where the nodes rest by complete iterations with hard contacts.
std::vector<Vec3> bag_at_rest(const Bag& bag);
Runs<PeerBag> own_bags(const Bag& bag, const std::vector<Vec3>& rest);
std::vector<PeerStability> own_stability(const std::vector<double>& stiffnesses,
                                         const std::vector<double>& steps, double duration);

inline constexpr std::size_t net_steps = 1000;  // of S6

/// Returns an integrator on the first steps of a scene, up to max_steps. Refers to the scene.
std::unique_ptr<TimedRun> own_timed_run(const ReferenceScene& scene, const std::string& integrator, double h,
                                        std::size_t max_steps);

}  // namespace godobject::study
