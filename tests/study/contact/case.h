// The reference cases with contacts, press and bounce: spheres on one body and the plane z = 0.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/oracle/solve.h"
#include "tests/study/contact/scene.h"

namespace godobject::study {

struct ContactCase {
  bench::ContactScene scene;
  oracle::Solution exact;
};

/// Those whose files are in `shared` (the folder with reference/); others are named in `skipped`, with the reason. Throws
/// std::runtime_error for a malformed file.
std::vector<ContactCase> contact_cases(const std::filesystem::path& shared,
                                       std::vector<std::string>& skipped);

/// Depth of the body's deepest sphere in the plane, m; 0 above it.
double penetration(const bench::ContactScene& scene, const oracle::RigidState& x);

/// Kinetic, of gravity, of the coupling to the target at time t and of the contacts' springs, J. Of the first body.
double mechanical_energy(const bench::ContactScene& scene, const oracle::RigidState& x, double t);

/// What a ball does between two impacts.
struct Flight {
  double apex = 0;     // above where it touches, m
  double landing = 0;  // s
};

/// The flights of a ball that began above the plane, of those that ended.
std::vector<Flight> flights(const bench::ContactScene& scene, const oracle::Solution& solution);

/// Speed after the first impact over that before; 0 where there was none.
double restitution(const std::vector<Flight>& flights);

/// Worst difference of height and time of every flight, shares of the exact one's. Infinite where one is missing.
double worst_flight_error(const std::vector<Flight>& flights, const std::vector<Flight>& exact);

}  // namespace godobject::study
