// Impedance that a hand feels through encoder, bus and drive: apparent mass, damping and stiffness by
// frequency.
//
// The device is one slide with a mass, a damping and an encoder of whole counts. Its hand moves it by a sine.
// A lock-in takes the hand's force, and the drive's force that displays the tool, at the frequency of the
// sine. Z = F / X with the force F that the hand exerts, so a mass m has Z = -m w^2.
#pragma once

#include <complex>
#include <limits>
#include <string>
#include <vector>

namespace godobject::study {

/// Way from the device's coordinate to the displayed force.
struct FeelPlan {
  std::string name;
  bool has_buses = false;  // without them the core receives the motion, and displays (8) at once
  double step_s = 1e-3;    // period of core and buses
  int status_every = 1;    // the drive sends its position at every n-th SYNC
  double count_m = 1e-6;   // one count of the encoder, with buses
};

/// Plans of the study: none, one bus at 1 kHz, positions at every second SYNC, 500 Hz, and coarser counts.
std::vector<FeelPlan> feel_plans();

struct FeelCase {
  FeelPlan plan;
  std::string integrator = "tr-bdf2";
  double damping_ratio = 1.4;  // of the coupling
  bool is_pressed = false;     // against a wall of 20 kN/m, 20 mm beyond the touch
  double speed = 0.05;         // m/s, largest one of the hand
};

/// Parameters of every case.
struct FeelTool {
  static constexpr double mass = 0.1;                // kg
  static constexpr double k = 1000;                  // coupling, N/m
  static constexpr double k_d = 200, g_d = 2.8;      // displayed (8), N/m and N s/m
  static constexpr double k_wall = 2e4, g_wall = 5;  // contact, N/m and N s/m
};

/// Mechanics of the device that is on the buses.
struct FeelDevice {
  static constexpr double mass = 0.05, damping = 0.5;  // kg, with the motor's rotor; N s/m
};

/// Impedance at one frequency, N/m.
struct Impedance {
  double f_Hz = 0;
  std::complex<double> Z;

  /// Returns the apparent mass, kg: that of a body which needs the same force in phase with its acceleration.
  double mass() const;
  double damping() const;  // N s/m
  double stiffness() const { return Z.real(); }
};

struct Felt {
  Impedance displayed;  // force of the drive
  Impedance hand;       // force of the hand: the device's own mechanics as well. Without buses as displayed
  // Root mean squares of the displayed force, N: of its sine, and of the rest, which counts cause.
  double sine_N = 0, ripple_N = 0;
};

/// Returns frequencies from 0.1 to 100 Hz, per_decade in each decade, whose periods are whole numbers of 2
/// ms.
std::vector<double> feel_frequencies(int per_decade);

/// Measures the impedance, in strokes of at most 5 mm while pressed. Throws std::runtime_error if the session
/// faults.
Felt measure_feel(const FeelCase& c, double f_Hz);

/// Returns the displayed impedance in continuous time: the coupled tool (1) whose force (8) is displayed. A
/// bus delays it by its period T and holds it for T; positions at every n-th SYNC are (n - 1) T/2 older in
/// the mean.
Impedance feel_by_law(const FeelCase& c, double f_Hz);

/// Returns the impedance of the device's own mass and damping, as SimPlant integrates them.
Impedance feel_of_device(double f_Hz);

/// Frequencies between which the sine of the displayed force exceeds its ripple, Hz. Below and above, counts
/// dominate. The defaults: they dominate everywhere.
struct CountBand {
  double lowest = std::numeric_limits<double>::infinity(), highest = 0;
};

/// Returns the band of measurements in ascending order of frequency; between two of them by interpolation.
/// Beyond the first and the last one it is 0 and infinite.
CountBand count_band(const std::vector<Felt>& felt);

/// Returns the largest displayed force, N, while the hand moves to and fro freely at up to 0.2 m/s, at 0.1
/// Hz.
double drag_of(const FeelCase& c);

/// Returns the time from a motion of the hand to its force, s: the lag of the displayed spring at 1 Hz. The
/// tool is at the wall, and the feedback has no damping.
double delay_of(const FeelPlan& plan);

}  // namespace godobject::study
