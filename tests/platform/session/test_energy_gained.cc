// No scene gains energy in silence: shipped and reference scenes do not, those that do say so.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>

#include "platform/scene/scene_toml.h"
#include "platform/session/make_session.h"
#include "tests/support/shared_data.h"

namespace godobject::test_energy_gained {
namespace {

/// What a run without a bus says of its energy.
struct Told {
  double most_J = 0;   // by which E - W rose above its least value, over the whole run
  double share = 0;    // of the energy at work, in the window of the watch
  double of_J = 0;     // the most that was at work in it
  bool fault = false;  // energy_gained
};

Told run(const SceneConfig& scene, double seconds) {
  Session::Made made = make_session(scene, Motion(scene), BusChoice::direct);
  EXPECT_TRUE(made.session) << made.errors.front();
  Told told;
  if (!made.session) return told;
  CycleRecord record = made.session->at_start();
  double least = record.energy.balance;
  while (record.t < seconds - scene.step / 2) {
    made.session->cycle(record);
    const EnergyReport& E = record.energy;
    least = std::min(least, E.balance);
    told.most_J = std::max(told.most_J, E.balance - least);
    told.of_J = std::max(told.of_J, E.at_work);
    if (E.gained > gain_floor) told.share = std::max(told.share, E.gained / E.at_work);
    told.fault = told.fault || has(record.fault, Fault::energy_gained);
  }
  return told;
}

TEST(EnergyGained, NotByAnyShippedOrReferenceScene) {
  for (const char* folder : {"/sim/scenes", "/sim/scenes/reference"}) {
    for (const auto& file : std::filesystem::directory_iterator(std::string(GODOBJECT_SOURCE_DIR) + folder)) {
      if (file.path().extension() != ".toml") continue;
      const LoadResult loaded = load_scene(file.path().string());
      ASSERT_TRUE(loaded.scene) << file.path();
      const Told told = run(*loaded.scene, 4);
      std::printf("%s: %.2g of the energy at work\n", file.path().stem().c_str(), told.share);
      EXPECT_FALSE(told.fault) << file.path();
    }
  }
}

// whose energy is the fall of their weights: they keep it, or it is told
TEST(EnergyGained, HeavyEndsKeepTheirEnergyOrSaySo) {
  for (const char* name : {"chain3-10000-tr-bdf2", "chain4-500-tr-bdf2", "chain5-2000-implicit-euler",
                           "chain5-500-implicit-euler"}) {
    const std::filesystem::path file = test::shared_file(std::string("attacks/heavy-end-") + name + ".toml");
    if (file.empty()) GTEST_SKIP() << "no attacks/ in the shared folder";
    const SceneConfig scene = load_scene(file.string()).scene.value();
    const Told told = run(scene, scene.duration);
    std::printf("%s: %.3g J\n", name, told.most_J);
    EXPECT_TRUE(told.fault || told.most_J < 5e-3 * told.of_J) << name << ": " << told.most_J << " J";
  }
}

}  // namespace
}  // namespace godobject::test_energy_gained
