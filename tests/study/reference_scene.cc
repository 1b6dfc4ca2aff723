#include "tests/study/reference_scene.h"

#include <algorithm>

#include "tests/oracle/case/reference_case.h"
#include "tests/oracle/scenes.h"
#include "tests/oracle/target.h"
#include "tests/study/joint/scene.h"

namespace godobject::study {
namespace {

using oracle::Quaterniond;
using oracle::Vector3d;

/// Scene of sim/scenes/reference/coupling-step.toml: at rest, released to a fixed target.
ReferenceScene coupling_step() {
  oracle::RigidState target;
  target.p = Vector3d(0.05, -0.03, 0.02);
  target.q =
      Quaterniond(0.796083798549056, 0.363111843441624, -0.387319299671065, 0.290489474753299).normalized();

  oracle::Body tool;
  tool.name = "tool";
  tool.m = 0.1;
  tool.I_B = Vector3d(0.000750833333333, 0.000750833333333, 1.66666666667e-06).asDiagonal();
  tool.coupling = {.k_t = 1000, .g_t = 14, .k_r = 1, .g_r = 0.0383618734336};
  tool.coupling->target = std::make_shared<oracle::FunctionTarget>([target](double) { return target; });

  ReferenceScene scene{.name = "coupling-step",
                       .about = "a slender body released to a fixed target pose",
                       .problem = {},
                       .duration = 1};
  scene.problem.bodies = {tool};
  return scene;
}

/// Scene of sim/scenes/reference/torque-free.toml: rotating about its intermediate axis.
ReferenceScene torque_free() {
  oracle::Body body;
  body.name = "body";
  body.m = 1;
  body.I_B = Vector3d(0.02, 0.05, 0.08).asDiagonal();
  body.start.v = Vector3d(0.1, -0.2, 0.3);
  body.start.w = Vector3d(0.01, 12, 0.02);

  ReferenceScene scene{.name = "torque-free",
                       .about = "a free body tumbling about its intermediate axis",
                       .problem = {},
                       .duration = 4};
  scene.problem.bodies = {body};
  return scene;
}

}  // namespace

ReferenceScene scene_s1() {
  return {.name = "S1",
          .about = "a slender body on a moving target, six sines",
          .problem = oracle::scene_s1(),
          .duration = 20,
          .from = 0.5};
}

ReferenceScene reference_s3() {
  return {.name = "S3",
          .about = "a grasper on a moving device: four bodies, four joints, roll at 4e4 1/s",
          .problem = scene_s3(),
          .duration = 10,
          .from = 0.5,
          .stiff = true};
}

ReferenceScene reference_chain() {
  return {.name = "S5",
          .about = "five equal links on ball joints, released at 45 degrees",
          .problem = scene_s5(5),
          .duration = 0.5};
}

std::vector<ReferenceScene> reference_scenes(const std::filesystem::path& shared,
                                             std::vector<std::string>& skipped) {
  std::vector<ReferenceScene> scenes{coupling_step(), scene_s1(), torque_free(), reference_s3(),
                                     reference_chain()};
  // name, description, duration limit in s, position; longer runs of chains and tops diverge from equal
  // starts
  const auto add = [&](const char* name, const char* about, double duration, std::size_t at) {
    const std::filesystem::path folder = shared / "reference" / name;
    if (!std::filesystem::exists(folder / "case.json")) {
      skipped.push_back(std::string(name) + ": its files were not found (set GODOBJECT_SHARED)");
      return;
    }
    const oracle::ReferenceCase loaded = oracle::load_reference_case(folder);
    scenes.insert(scenes.begin() + static_cast<std::ptrdiff_t>(at),
                  {.name = name,
                   .about = about,
                   .problem = loaded.problem,
                   .duration = std::min(duration, loaded.duration)});
  };
  add("chain-5", "five links on ball joints, the last ten times heavier, from a file", 0.5, scenes.size());
  add("heavy-top", "a fast top on a ball joint, from a file", 0.5, scenes.size());
  add("coupling-lissajous", "a very slender body on a moving target, from a file", 100, 1);
  return scenes;
}

}  // namespace godobject::study
