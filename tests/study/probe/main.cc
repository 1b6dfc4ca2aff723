// godobject_probe: runs the step of one composition a given number of times under callgrind.
//   godobject_probe COMPOSITION STEPS MOTION     runs, e.g. godobject_probe "haptic-1 tr-bdf2" 500 s1
//   godobject_probe                              lists name,params,state,scratch (bytes) of every composition
// Motions: s1, s1-full (as many bodies as fit), s3, s5 (likewise), pair-<kind of joint>, pair-free; each also as <motion>-slow,
// a smaller and slower one on which a step has as many instructions, if they do not depend on the data. With contacts: s2,
// s2-smooth (without friction) and s4, run until they are in full contact before the steps that were asked for.
#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include "tests/study/articulated_scene.h"
#include "tests/study/contact_run.h"
#include "tests/study/probe/probe_step.h"

namespace godobject::study {
namespace {

struct Probe {
  std::string name;
  std::size_t params_bytes, state_bytes, scratch_bytes;
  bool (*run)(const std::string& motion, std::size_t steps);
};

std::optional<oracle::JointType> joint_type(const std::string& kind) {
  using enum oracle::JointType;
  for (const auto& [name, type] : {std::pair{"fixed", fixed},
                                   {"ball", ball},
                                   {"hinge", hinge},
                                   {"slider", slider},
                                   {"cylindrical", cylindrical},
                                   {"universal", universal}})
    if (kind == name) return type;
  return std::nullopt;
}

/// Empty for a motion that does not exist.
oracle::Case case_of(std::string motion, std::size_t max_bodies) {
  Motion size;
  if (motion.ends_with("-slow")) {
    motion.resize(motion.size() - 5);
    size = {.amplitude = 0.2, .rate = 0.3};
  }
  if (motion == "s1") return scene_s1(size);
  if (motion == "s1-full") return copies(scene_s1(size), max_bodies);
  if (motion == "s3") return scene_s3(size);
  if (motion == "s5") {
    oracle::Case chain = scene_s5(max_bodies);
    chain.gravity *= size.amplitude;
    return chain;
  }
  if (!motion.starts_with("pair-")) return {};
  const auto type = joint_type(motion.substr(5));
  if (type) return scene_pair(*type, size);
  oracle::Case apart = scene_pair(oracle::JointType::fixed, size);
  apart.joints.clear();
  return motion == "pair-free" ? apart : oracle::Case{};
}

constexpr double pressing_stiffness = 1e4;  // N/m, of S2

struct ProbeScene {
  bench::ContactScene scene;
  std::size_t steps_before = 0;  // steps until what is to be counted begins
};

ProbeScene scene_of(const std::string& motion, std::size_t max_bodies) {
  if (motion == "s4") return {bench::scene_s4(max_bodies, 20), 1000};
  if (motion.starts_with("s2")) {
    ProbeScene s2{bench::scene_s2(pressing_stiffness), 2000};
    if (motion == "s2-smooth") s2.scene.law.mu = 0;
    return s2;
  }
  ProbeScene other;
  other.scene.problem = case_of(motion, max_bodies);
  return other;
}

/// A scene type with all parts the case has.
template <Scene S>
bool holds(const oracle::Case& problem) {
  if (problem.bodies.empty() || problem.bodies.size() > S::max_bodies) return false;
  if (!problem.joints.empty() && !uses<typename S::Joints>) return false;
  return !uses<typename S::Device> || problem.bodies[0].coupling.has_value();
}

template <Scene S>
bool run(const std::string& motion, std::size_t steps) {
  const ProbeScene probe = scene_of(motion, S::max_bodies);
  if (!holds<S>(probe.scene.problem)) return false;
  const auto scene = std::make_unique<CaseRun<S>>(probe.scene.problem, 1e-3);
  set_contacts(probe.scene, scene->params());
  Fault fault = Fault::none;
  for (const Input<S>& in : scene->inputs(probe.steps_before + steps, 1e9)) {
    probe_step<S>(scene->params(), in, scene->state(), scene->scratch(), scene->output());
    fault |= scene->output().fault;
  }
  return !any(fault);
}

template <Scene S>
Probe probe(const std::string& scene) {
  return {.name = scene + "-" + std::to_string(S::max_bodies) + " " + S::Integrator::name,
          .params_bytes = sizeof(Params<S>),
          .state_bytes = sizeof(State<S>),
          .scratch_bytes = sizeof(Scratch<S>),
          .run = run<S>};
}

/// With both integrators.
template <template <class, std::size_t> class SceneOf, std::size_t... capacities>
void add(std::vector<Probe>& probes, const std::string& scene) {
  (probes.push_back(probe<SceneOf<ImplicitEuler, capacities>>(scene)), ...);
  (probes.push_back(probe<SceneOf<TrBdf2, capacities>>(scene)), ...);
}

/// Those of tests/study/CMakeLists.txt.
std::vector<Probe> all_probes() {
  std::vector<Probe> probes;
  add<Free, 1, 8>(probes, "free");
  add<DeviceOnly, 1, 8>(probes, "device");
  add<Follower, 1, 8>(probes, "pose");
  add<Haptic, 1, 8>(probes, "haptic");
  add<Relative, 1, 8>(probes, "relative");
  add<Admittance, 1, 8>(probes, "admittance");
  add<FreeJoints, 1, 8, 64, 256>(probes, "free-joints");
  add<Tool, 2, 4>(probes, "pose-joints");
  add<ToolWithStops, 4>(probes, "pose-joints-stops");
  add<ToolWithImposed, 4>(probes, "pose-joints-imposed");
  add<ToolWithAll, 4>(probes, "pose-joints-stops-imposed");
  add<Tool, 1>(probes, "pressed");
  add<PressedTool, 1>(probes, "pressed-contacts");
  probes.push_back(probe<Follower<ImplicitEuler, 64>>("bricks"));
  probes.push_back(probe<Bricks<ImplicitEuler, 64>>("bricks-contacts"));
  return probes;
}

int main(const std::vector<std::string>& arguments) {
  if (arguments.empty()) {
    for (const Probe& p : all_probes())
      std::cout << p.name << ',' << p.params_bytes << ',' << p.state_bytes << ',' << p.scratch_bytes << '\n';
    return 0;
  }
  for (const Probe& p : all_probes())
    if (arguments.size() == 3 && p.name == arguments[0])
      return p.run(arguments[2], std::stoul(arguments[1])) ? 0 : 1;
  std::cerr << "usage: godobject_probe [COMPOSITION STEPS MOTION]\n";
  return 2;
}

}  // namespace
}  // namespace godobject::study

int main(int argc, char** argv) {
  return godobject::study::main(std::vector<std::string>(argv + 1, argv + argc));
}
