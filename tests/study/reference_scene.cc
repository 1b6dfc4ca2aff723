#include "tests/study/reference_scene.h"

#include <memory>
#include <numbers>

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

/// Scene of sim/scenes/reference/coupling-lissajous.toml.
ReferenceScene coupling_lissajous() {
  ReferenceScene scene = coupling_step();
  scene.name = "coupling-lissajous";
  scene.about = "a very slender body on a moving target";
  scene.duration = 2;
  oracle::Body& tool = scene.problem.bodies.front();
  tool.coupling->target = std::make_shared<oracle::FunctionTarget>(oracle::lissajous_device);
  tool.start = oracle::lissajous_device(0);
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

/// Scene of sim/scenes/reference/chain-5.toml: the links of S5, thinner, released from the horizontal.
ReferenceScene chain_5() {
  ReferenceScene scene = reference_chain();
  scene.name = "chain-5";
  scene.about = "five links on ball joints, the last ten times heavier";
  for (oracle::Body& link : scene.problem.bodies) {
    link.m = &link == &scene.problem.bodies.back() ? 0.5 : 0.05;
    link.I_B = link.m * Vector3d(8.41666666667e-04, 8.41666666667e-04, 1.66666666667e-05).asDiagonal();
    link.start.q = Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitY()));
    link.start.p = Vector3d(link.start.p.norm(), 0, 0);
  }
  return scene;
}

/// Scene of sim/scenes/reference/heavy-top.toml, as long as runs from equal starts stay together.
ReferenceScene heavy_top() {
  oracle::Body top;
  top.name = "top";
  top.m = 15;
  top.I_B = Vector3d(0.234375, 0.46875, 0.234375).asDiagonal();
  top.start.p = Vector3d(0, 1, 0);
  top.start.v = Vector3d(4.61538, 0, 0);
  top.start.w = Vector3d(0, 150, -4.61538);

  ReferenceScene scene{
      .name = "heavy-top", .about = "a fast top on a ball joint", .problem = {}, .duration = 0.5};
  scene.problem.gravity = {0, 0, -9.81};
  scene.problem.bodies = {top};
  scene.problem.joints = {{.name = "pivot", .child = 0, .anchor_C = Vector3d(0, -1, 0)}};
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

std::vector<ReferenceScene> reference_scenes() {
  return {coupling_step(), coupling_lissajous(), scene_s1(), torque_free(),
          reference_s3(),  reference_chain(),    chain_5(),  heavy_top()};
}

}  // namespace godobject::study
