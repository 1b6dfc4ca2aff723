// No shipped or reference scene raises the fault energy_gained. For ../shared/attacks see
// test_attack_scenes.cc.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>

#include "platform/scene/toml.h"
#include "platform/simulated/session.h"

namespace godobject::test_energy_gained {
namespace {

/// Energy results of a run without a bus.
struct EnergyResult {
  double share = 0;    // of the energy at work, in the window of the watch
  bool fault = false;  // energy_gained
};

EnergyResult run(const SceneConfig& scene, double seconds) {
  Session::Made made = make_session(scene, Motion(scene), BusChoice::direct);
  EXPECT_TRUE(made.session) << made.errors.front();
  EnergyResult result;
  if (!made.session) return result;
  CycleRecord record = made.session->at_start();
  while (record.t < seconds - scene.step / 2) {
    made.session->cycle(record);
    const EnergyReport& E = record.energy;
    if (E.gained > gain_floor) result.share = std::max(result.share, E.gained / E.at_work);
    result.fault = result.fault || has(record.fault, Fault::energy_gained);
  }
  return result;
}

TEST(EnergyGained, NotByAnyShippedOrReferenceScene) {
  for (const char* folder : {"/sim/scenes", "/sim/scenes/reference"}) {
    for (const auto& file : std::filesystem::directory_iterator(std::string(GODOBJECT_SOURCE_DIR) + folder)) {
      if (file.path().extension() != ".toml") continue;
      const LoadResult loaded = load_scene(file.path().string());
      ASSERT_TRUE(loaded.scene) << file.path();
      const EnergyResult result = run(*loaded.scene, 4);
      std::printf("%s: %.2g of the energy at work\n", file.path().stem().c_str(), result.share);
      EXPECT_FALSE(result.fault) << file.path();
    }
  }
}

}  // namespace
}  // namespace godobject::test_energy_gained
