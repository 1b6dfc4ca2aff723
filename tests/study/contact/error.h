// Error, penetration and energy against run time on the reference cases with contacts.
#pragma once

#include "tests/study/contact/case.h"
#include "tests/study/error_study.h"

namespace godobject::study {

struct ContactErrorRow {
  std::string scene;
  std::string integrator;
  double h = 0;  // s
  // Largest differences from the reference, at those of its times that are multiples of 2 ms:
  double position = 0;     // m
  double penetration = 0;  // depth of the deepest sphere, m
  double energy = 0;       // J
  // J, largest rise of the energy between any two steps; for bounce, where energy cannot rise
  double rise = 0;
  // order of the position, from the row at 2 h
  std::optional<double> order{};
  std::optional<double> restitution{};  // bounce: at the first impact
  // relative to the exact one; order from the row at 2 h
  std::optional<double> restitution_error{}, restitution_order{};
  std::optional<double> flight_error{};  // bounce: worst error of any flight's height and time, as a share
  double ns_per_step = 0;                // median

  double ns_per_second() const { return ns_per_step / h; }  // per simulated second
};

struct ContactErrors {
  std::vector<ContactErrorRow> rows;            // by case, integrator, step; slowest first
  std::optional<double> restitution_reference;  // restitution of the law, if bounce was run
};

/// Runs press at 2 to 0.125 ms and bounce at 2 to 1/32 ms, with both integrators.
ContactErrors study_contact_errors(const std::vector<ContactCase>& cases, bool quick,
                                   const Progress& progress);

const ContactErrorRow* find(const std::vector<ContactErrorRow>& rows, const std::string& scene,
                            const std::string& integrator, double h);

void write_csv(const std::filesystem::path& file, const std::vector<ContactErrorRow>& rows);

}  // namespace godobject::study
