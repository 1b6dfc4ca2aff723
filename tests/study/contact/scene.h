// Scenes S2 and S4: bodies in contact with each other and the plane z = 0, with equal numbers here and for
// the peers.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/contact/contact.h"
#include "tests/oracle/case/case.h"

namespace godobject::bench {

/// Only the first body is coupled. All bodies have the same contact shapes.
struct ContactScene {
  std::string name;
  oracle::Case problem;
  double duration = 0;               // s
  std::vector<Vec3> centres;         // sphere centres of each body, body axes, m
  double radius = 0;                 // radius of the spheres, m
  std::optional<Vec3> half_extents;  // every body is this box, m; boxes of the peers have sharp corners
  ContactLaw law;                    // mu applies to all; the other values to contacts that are springs

  const oracle::Coupling& coupling() const { return *problem.bodies.front().coupling; }
};

/// S2: a spring of stiffness k (N/m) presses ten spheres in a row 2 cm into the plane and drags them; 10 s.
ContactScene scene_s2(double k);

/// S4: a brick dragged through a pile of 63. Further bricks form more such piles at rest. Bricks are in
/// contact by spheres at their corners, and by their edges.
ContactScene scene_s4(std::size_t num_bricks, double duration);

}  // namespace godobject::bench
