// Impedance that a hand feels through encoder, bus and drive: apparent mass, damping and stiffness by
// frequency.
//
// The device is one slide. Its hand moves it by a sine, and the displayed force is that of the drive. A
// lock-in takes both at the frequency of the sine. Z = F / X with the force F of the hand, so a mass m has
// Z = -m w^2.
#pragma once

#include <complex>
#include <cstddef>
#include <string>
#include <vector>

namespace godobject::study {

/// Way from the device's coordinate to the displayed force.
struct FeelPlan {
  std::string name;
  bool has_buses = false;  // without them the core receives the motion, and displays (8) at once
  double step_s = 1e-3;    // period of core and buses
  int status_every = 1;    // the drive sends its position at every n-th SYNC
};

/// Plans of the study: none, one bus at 1 kHz, positions at every second SYNC, and 500 Hz.
std::vector<FeelPlan> feel_plans();

struct FeelCase {
  FeelPlan plan;
  std::string integrator = "tr-bdf2";
  double damping_ratio = 1.4;  // of the coupling
  bool is_pressed = false;     // against a wall of 20 kN/m, 20 mm beyond the touch
};

/// Parameters of every case.
struct FeelTool {
  static constexpr double mass = 0.1;                // kg
  static constexpr double k = 1000;                  // coupling, N/m
  static constexpr double k_d = 200, g_d = 2.8;      // displayed (8), N/m and N s/m
  static constexpr double k_wall = 2e4, g_wall = 5;  // contact, N/m and N s/m
};

struct Felt {
  double f_Hz = 0;
  std::complex<double> Z;  // N/m

  /// Returns the apparent mass, kg: that of a body which needs the same force in phase with its acceleration.
  double mass() const;
  double damping() const;  // N s/m
  double stiffness() const { return Z.real(); }
};

/// Returns frequencies from 0.1 to 100 Hz, per_decade in each decade, whose periods are whole numbers of 2
/// ms.
std::vector<double> feel_frequencies(int per_decade);

/// Measures the impedance. Throws std::runtime_error if the session faults.
Felt measure_feel(const FeelCase& c, double f_Hz);

/// Returns the impedance in continuous time of the coupled tool (1) whose force (8) is displayed. A bus
/// delays it by its period T and holds it for T; positions at every n-th SYNC are (n - 1) T/2 older in the
/// mean.
Felt feel_by_law(const FeelCase& c, double f_Hz);

/// Returns the largest displayed force, N, while the hand moves to and fro freely at up to 0.2 m/s, at 0.1
/// Hz.
double drag_of(const FeelCase& c);

/// Returns the time from a motion of the hand to its force, s: the lag of the displayed spring at 1 Hz. The
/// tool is at the wall, and the feedback has no damping.
double delay_of(const FeelPlan& plan);

}  // namespace godobject::study
