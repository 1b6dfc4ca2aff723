// Stability map of contacts: stiffness x damping x step, for each integrator.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/study/error_study.h"

namespace godobject::study {

/// Gains above this count, J: rounding of energies of some joules is smaller.
inline constexpr double max_contact_gain = 1e-9;

struct ContactCell {
  double k = 0;        // N/m, per sphere
  double damping = 0;  // c / (2 sqrt(m k))
  double h = 0;        // s
};

struct ContactStability {
  std::string integrator;
  ContactCell cell;
  bool failed = false;  // a fault, or a value that is not finite
  double gain = 0;      // J
};

struct ContactGrid {
  std::vector<double> dampings, stiffnesses, steps;
};
ContactGrid contact_grid(bool quick);

/// Runs two cases and returns the larger energy gain. A rod of 0.1 kg on five spheres, friction 0.5, starts 8
/// cm above a plane. It is thrown at the plane and rolls; or a coupling presses it into the plane and drags
/// it to and fro. Gain: energy of body, coupling and gravity beyond the initial energy and the work of the
/// hand, at any time within 0.6 s and 2000 steps. The contacts' springs are not included, because their
/// energy comes from these.
ContactStability contact_gain(const std::string& integrator, const ContactCell& cell);

/// Returns rows by integrator, damping, stiffness, step; the last varies fastest.
std::vector<ContactStability> study_contact_stability(const ContactGrid& grid, const Progress& progress);

void write_csv(const std::filesystem::path& file, const std::vector<ContactStability>& rows);

}  // namespace godobject::study
