// Sweeps of bench_sweep.py in C++: short runs of a scene, a part of a sweep for each line of input.
// usage: godobject_sweep SCENE STEPS
// Input: "KIND FIRST RUNS". KIND: "parsed", one scene for all runs; "parsed_each", a scene that is parsed for
// each run, with another mass of its first body. FIRST: number of the part's first run. Output: processor
// time, s, and hash of the last state.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <string_view>

#include "platform/rig/buses.h"
#include "platform/scene/text/diagnostics.h"
#include "platform/simulated/session.h"

namespace godobject {
namespace {

/// Runs a session for a number of steps. Returns the hash of its state; 0 if it does not start.
std::uint64_t run(SceneConfig scene, const std::string& file, int steps) {
  const bool simulated = scene.device && scene.device->rig;
  std::vector<std::string> errors;
  RigProfiles profiles;
  if (simulated) profiles = checked_profiles(scene, file, errors);
  Motion motion(scene);
  const Session::Made made = make_session(std::move(scene), std::move(motion),
                                          simulated ? BusChoice::sim : BusChoice::direct, profiles);
  if (!made.session || !made.session->boot(usual_boot_limit_s)) return 0;
  CycleRecord record = made.session->at_start();
  for (int i = 0; i < steps; ++i) static_cast<void>(made.session->advance(record));
  return made.session->engine().state_hash();
}

double mass_of_run(double mass, int i) { return mass * (1 + 1e-4 * i); }

/// Returns the text with the first mass of the scene replaced.
std::string with_mass(const std::string& text, const std::string& key, double mass) {
  const std::size_t begin = text.find(key) + key.size();
  return text.substr(0, begin) + std::to_string(mass) + text.substr(text.find('\n', begin));
}

template <class F>
void time(int first, int runs, F f) {
  std::uint64_t hash = 0;
  const std::clock_t start = std::clock();
  for (int i = first; i < first + runs; ++i) hash = f(i);
  const double took = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  std::printf("%.6f %016llx\n", took, static_cast<unsigned long long>(hash));
  std::fflush(stdout);
}

int sweep(const std::string& path, int steps) {
  const std::optional<std::string> text = read_text(path);
  const LoadResult loaded = load_scene(path, simulated_faults());
  if (!text || !loaded.scene) return 1;
  const double mass = loaded.scene->bodies.front().mass;
  std::array<char, 16> kind{};
  int first = 0, runs = 0;
  while (std::scanf("%15s %d %d", kind.data(), &first, &runs) == 3) {
    if (kind.data() == std::string_view("parsed")) {
      time(first, runs, [&](int) { return run(*loaded.scene, path, steps); });
      continue;
    }
    time(first, runs, [&](int i) {
      const std::string with = with_mass(*text, "\nmass = ", mass_of_run(mass, i));
      return run(*parse_scene(with, path, simulated_faults()).scene, path, steps);
    });
  }
  return 0;
}

}  // namespace
}  // namespace godobject

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  return godobject::sweep(argv[1], std::atoi(argv[2]));
}
