// Quality of contacts in a run, of our step or a peer.
#pragma once

#include <functional>

#include "tests/study/contact/scene.h"

namespace godobject::bench {

struct ContactQuality {
  /// S2, after 3 s: depth of spheres in the plane, m, and the rms of its change from step to step, m.
  struct Depth {
    double mean = 0, jitter = 0;
  };

  double contacts = 0;  // their number, mean of all steps
  Depth deepest;        // of the deepest sphere: moves when the tool tilts
  Depth average;        // of the ten: balanced by the springs, constant under dragging
  double overlap = 0;   // m: S4, of the two bricks deepest in each other as boxes, largest of 200 instants
  double overlap_median = 0;  // m: and median
  double speed = 0;           // m/s: S4, largest of a brick that is not pulled
};

/// After a step.
struct Snapshot {
  std::vector<oracle::RigidState> bodies;
  std::size_t num_contacts = 0;
};

/// Runs `steps` steps, of which step(n) takes one.
ContactQuality quality_of(const ContactScene& scene, std::size_t steps,
                          const std::function<Snapshot(std::size_t n)>& step);

/// How deep two boxes of these half extents are in each other, m, by the separating-axis test; 0 if apart.
double box_overlap(const Vec3& half_extents, const oracle::RigidState& a, const oracle::RigidState& b);

}  // namespace godobject::bench
