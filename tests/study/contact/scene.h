// Scenes S2 and S4: bodies that touch each other and the plane z = 0, the same numbers for us and for the peers.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/contact/contact.h"
#include "tests/oracle/case/case.h"

namespace godobject::bench {

/// Only the first body is coupled. Bodies are alike in what they touch with.
struct ContactScene {
  std::string name;
  oracle::Case problem;
  double duration = 0;               // s
  std::vector<Vec3> centres;         // of the spheres of each body, body axes, m
  double radius = 0;                 // of these, m
  std::optional<Vec3> half_extents;  // every body is this box, m; others' boxes have sharp corners
  ContactLaw law;                    // mu is everybody's, the rest is for those whose contacts are springs

  const oracle::Coupling& coupling() const { return *problem.bodies.front().coupling; }
};

/// S2: ten spheres in a row are pressed 2 cm into the plane by a spring of k (N/m), and dragged; 10 s.
ContactScene scene_s2(double k);

/// S4: a brick that is dragged through a pile of 63; of more, all in such piles, the others rest. Bricks touch with
/// spheres at their corners, and their edges.
ContactScene scene_s4(std::size_t num_bricks, double duration);

}  // namespace godobject::bench
