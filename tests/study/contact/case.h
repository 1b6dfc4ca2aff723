// The reference cases with contacts, press and bounce: spheres on one body and the plane z = 0.
#pragma once

#include <string>
#include <vector>

#include "tests/oracle/solve.h"
#include "tests/study/contact/scene.h"

namespace godobject::study {

struct ContactCase {
  bench::ContactScene scene;
  oracle::Solution exact;
};

/// Returns the cases with the oracle's solutions, every 10 ms of press and 2.5 ms of bounce.
std::vector<ContactCase> contact_cases();

/// Returns the depth of the body's deepest sphere in the plane, m; 0 above it.
double penetration(const bench::ContactScene& scene, const oracle::RigidState& x);

/// Returns the energy of the first body at time t, J: kinetic, gravity, coupling to the target, springs of
/// the contacts.
double mechanical_energy(const bench::ContactScene& scene, const oracle::RigidState& x, double t);

/// Motion of a ball between two impacts.
struct Flight {
  double apex = 0;     // height above the contact, m
  double landing = 0;  // s
};

/// Returns the completed flights of a ball that began above the plane.
std::vector<Flight> flights(const bench::ContactScene& scene, const oracle::Solution& solution);

/// Returns the speed after the first impact over that before it; 0 without an impact.
double restitution(const std::vector<Flight>& flights);

/// Returns the largest error of height and time over all flights, as a share of the exact value; infinite if
/// a flight is missing.
double worst_flight_error(const std::vector<Flight>& flights, const std::vector<Flight>& exact);

}  // namespace godobject::study
