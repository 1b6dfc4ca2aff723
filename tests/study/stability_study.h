// Stability map: coupling stiffness x step x damping ratio x inertia ratio, for each integrator and, as
// contrast, for an explicitly integrated coupling.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/integrator_implicit_euler.h"
#include "core/integrator_tr_bdf2.h"
#include "tests/study/error_study.h"

namespace godobject::study {

/// Outcome of a free oscillation. The target rests, so the exact energy of tool plus spring never rises.
enum class Stability : std::uint8_t {
  stable,  // none of the following
  // translation: within one undamped period (at least one step), it loses over 10 % of the initial energy
  // more than exact
  dissipative,
  energy_gaining,  // the energy rises, between any two steps, by more than 1e-9 of the initial one
  failed,          // a fault, a value that is not finite, or more than 1e6 times the initial energy
};
inline constexpr std::array stability_names{"stable", "dissipative", "energy-gaining", "failed"};

inline constexpr double max_energy_loss = 0.1;
inline constexpr double max_energy_rise = 1e-9;
inline constexpr double max_energy_ratio = 1e6;

/// The explicitly integrated coupling, as contrast.
inline constexpr const char* explicit_name = "explicit";
inline constexpr std::array stability_schemes{ImplicitEuler::name, TrBdf2::name, explicit_name};

/// Mass 0.1 kg; a rod with moments of inertia I, I, I / inertia_ratio, I = m (0.1 m)^2; k_r = k (0.1 m)^2.
/// Translation and the slow rotation thus have the same frequency sqrt(k / m). Starts at rest, 0.1 m and 1
/// rad away.
struct StabilityCell {
  double k = 0;              // N/m
  double h = 0;              // s
  double damping = 0;        // g / sqrt(m k) = g_r / sqrt(I k_r), 0..2
  double inertia_ratio = 1;  // >= 1

  double wh() const;  // h sqrt(k / m)
};

struct StabilityResult {
  std::string scheme;  // one of stability_schemes
  StabilityCell cell;
  Stability stability = Stability::failed;
  double rise = 0;  // largest rise of the energy, share of the initial one; NaN if failed
  // largest loss beyond that of the exact solution, share of the initial energy; NaN if failed
  double loss = 0;
};

struct StabilityGrid {
  std::vector<double> stiffnesses, steps, dampings, inertia_ratios;
};

StabilityGrid stability_grid(bool quick);

/// Runs one cell for one period of the undamped spring, at least 1000 steps.
StabilityResult classify(const std::string& scheme, const StabilityCell& cell);

/// Runs every cell with every scheme: by scheme, damping, inertia ratio, stiffness, step; the last varies
/// fastest.
std::vector<StabilityResult> study_stability(const StabilityGrid& grid, const Progress& progress);

/// Returns the theoretical limit of stable h sqrt(k/m) of the explicitly integrated coupling. Translation: 2
/// (sqrt(z^2 + 1) - z), with z = damping / 2. Rotation about the rod's axis has the tighter limit: its
/// frequency and z are sqrt(inertia_ratio) times larger.
double explicit_limit(double damping, double inertia_ratio = 1);

/// Returns the measured limit in translation, by bisection on the energy after 100 000 steps.
double measured_explicit_limit(double damping);

void write_csv(const std::filesystem::path& file, const std::vector<StabilityResult>& results);

}  // namespace godobject::study
