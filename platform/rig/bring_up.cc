#include "platform/rig/bring_up.h"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <thread>
#include <utility>

#include "hal/rig/commissioning.h"
#include "hal/rig/profile_validate.h"
#include "hal/rig/rig.h"
#include "hal/rig/watchdog.h"
#include "platform/rt/clock.h"
#include "platform/scene/toml.h"

namespace godobject {
namespace {

constexpr std::chrono::milliseconds stop_poll{20}, commissioning_poll{1};

/// Waits until the other end of each pseudo-terminal is open, because the bus is down until then. Returns
/// false at `stop`.
bool wait_for_other_ends(const RigOnBuses& real, const std::atomic<bool>& stop) {
  for (std::size_t i = 0; i < real.link.num_buses(); ++i)
    if (real.has_other_end(i))
      std::fprintf(stderr, "bus %s: waiting for the other end of %s\n", real.rig.buses[i].name.c_str(),
                   real.link.bus(i).name().c_str());
  const auto one_waits = [&] {
    drain(real.link);
    for (std::size_t i = 0; i < real.link.num_buses(); ++i)
      if (real.has_other_end(i) && is_cut_off(real.link.bus(i).state())) return true;
    return false;
  };
  while (one_waits())
    if (!pause(0, stop)) return false;
  return true;
}

}  // namespace

RigProfiles checked_profiles(SceneConfig& scene, const std::string& scene_file,
                             std::vector<std::string>& errors) {
  RigParams& rig = *scene.device->rig;
  RigProfilesResult loaded =
      load_profiles(rig, scene.step, std::filesystem::path(scene_file).parent_path().string(), scene_file);
  errors.insert(errors.end(), loaded.errors.begin(), loaded.errors.end());
  if (loaded.errors.empty() && shows_force(scene.device->kind))
    for (const std::string& line : missing_watchdogs(rig, scene.step, loaded.profiles))
      errors.push_back(scene_file + ": " + line);
  apply_profiles(loaded.profiles, rig);
  return std::move(loaded.profiles);
}

void drain(LinuxLink& link) {
  ReceivedFrame ignored;
  for (CanBus* bus : link.buses()) {
    int left = Rig::max_frames_per_receive;
    while (left > 0 && bus->try_receive(ignored)) --left;
  }
}

bool pause(double s, const std::atomic<bool>& stop) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(s);
  do {
    std::this_thread::sleep_for(stop_poll);
  } while (!stop && std::chrono::steady_clock::now() < end);
  return !stop;
}

std::vector<std::string> commission(const RigOnBuses& real, const std::atomic<bool>& stop) {
  Commissioning nodes(real.rig, real.cycle_s, real.profiles, real.link.buses());
  const MonotonicClock clock;
  while (!nodes.done() && !stop) {
    nodes.poll(clock.now());
    std::this_thread::sleep_for(commissioning_poll);
  }
  return nodes.failed() ? nodes.errors() : std::vector<std::string>{};
}

std::vector<std::string> bring_up(const RigOnBuses& real, const std::atomic<bool>& stop) {
  if (!wait_for_other_ends(real, stop)) return {};
  return commission(real, stop);
}

std::vector<LastWords> last_words(const RigParams& params, double cycle_s, LinuxLink& link) {
  std::vector<FrameNotebook> notes(link.num_buses());
  std::vector<CanBus*> buses;
  for (FrameNotebook& note : notes) buses.push_back(&note);
  Rig rig(params, cycle_s, buses);
  rig.start(0);
  rig.stop();
  std::vector<LastWords> words;
  for (std::size_t i = 0; i < notes.size(); ++i) {
    words.push_back({.descriptor = link.bus(i).descriptor(), .writes = {}, .rest = link.bus(i).line_rest()});
    for (const CanFrame& frame : notes[i].frames())
      words.back().writes.push_back(link.bus(i).as_written(frame));
  }
  return words;
}

}  // namespace godobject
