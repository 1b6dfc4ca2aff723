// The stability map of contacts: stiffness x damping x step, for each integrator.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/study/error_study.h"

namespace godobject::study {

/// A gain beyond it, J, counts: rounding in energies of some joules stays below.
inline constexpr double max_contact_gain = 1e-9;

struct ContactCell {
  double k = 0;        // N/m, of each sphere
  double damping = 0;  // c / (2 sqrt(m k))
  double h = 0;        // s
};

struct ContactStability {
  std::string integrator;
  ContactCell cell;
  bool failed = false;  // a fault, or a number that is not finite
  double gain = 0;      // J
};

struct ContactGrid {
  std::vector<double> dampings, stiffnesses, steps;
};
ContactGrid contact_grid(bool quick);

/// A rod of 0.1 kg on five spheres, friction 0.5, 8 cm above a plane. Thrown at it and let roll; and pressed into it by a
/// coupling and dragged to and fro. The larger gain of the two: of the energy of body, coupling and gravity beyond the
/// first and the work of the hand, at any time within 0.6 s and at most 2000 steps. Energy in the contacts' springs, which
/// came from there, is not in it.
ContactStability contact_gain(const std::string& integrator, const ContactCell& cell);

/// By integrator, damping, stiffness, step, the last the quickest.
std::vector<ContactStability> study_contact_stability(const ContactGrid& grid, const Progress& progress);

void write_csv(const std::filesystem::path& file, const std::vector<ContactStability>& rows);

}  // namespace godobject::study
