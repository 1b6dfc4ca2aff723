// Stability map: drawn scenes of eight families, each run with both integrators, and the figures of each run.
// A sample depends on its seed and number alone, so that any one can be repeated.
#pragma once

#include <cstdint>
#include <string>

#include "tests/core/one_body.h"

namespace godobject::study {

/// One drawn scene and its run.
struct MapSample {
  std::uint64_t number = 0;
  std::string family = {}, integrator = {};
  std::string kind = {};  // within the family: of joints, of scene

  // drawn
  double step = 0;        // s
  double coupling = 0;    // largest stiffness of a coupling, N/m
  double contact = 0;     // largest stiffness of a contact law, N/m
  double mass_ratio = 1;  // of the heaviest body or node to the lightest; family free: of principal moments
  double damping = 0;     // largest damping ratio of a coupling, g / sqrt(m k)
  double speed = 0;       // largest speed of a target, m/s
  double spin = 0;        // largest initial angular velocity, rad/s

  // of the run
  int steps = 0;
  std::uint32_t fault = 0;   // bits of the first step with a fault, which ends the run
  bool is_reported = false;  // the energy balance of the program reports a gain of 1 % within 1 s
  // largest lasting rise of E - W, above the floor of (38), as a share of the largest energy at work
  double gain = 0;
  double divergence = 0;  // largest kinetic energy as a share of the energy that the scene had or was given
  double distance = 0;    // largest distance of a body or node from its start, m

  bool gains_silently() const { return fault == 0 && !is_reported && !(gain <= max_silent_gain); }
  static constexpr double max_silent_gain = 1e-3;
};

inline constexpr const char* map_families[] = {"free",   "chain", "pile", "grip",
                                               "valley", "net",   "loop", "gear"};
inline constexpr std::size_t num_map_families = std::size(map_families);

/// Runs a sample. Families take turns with the number. Each scene is run with implicit Euler, then with
/// TR-BDF2.
MapSample map_sample(std::uint64_t seed, std::uint64_t number);

/// Runs of each family; random: draws the scene. Instances: ImplicitEuler, TrBdf2.
template <class I>
void run_free(Random& random, MapSample& sample);
template <class I>
void run_chain(Random& random, MapSample& sample);
template <class I>
void run_pile(unsigned seed, MapSample& sample);
template <class I>
void run_grip(unsigned seed, MapSample& sample);
template <class I>
void run_valley(Random& random, MapSample& sample);
template <class I>
void run_net(unsigned seed, MapSample& sample);
template <class I>
void run_loop(Random& random, MapSample& sample);
template <class I>
void run_gear(Random& random, MapSample& sample);

}  // namespace godobject::study
