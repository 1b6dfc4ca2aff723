// godobject_probe: runs the step of one composition a given number of times under callgrind.
//   godobject_probe COMPOSITION STEPS BODIES     runs, e.g. godobject_probe "haptic-1 tr-bdf2" 500 1
//   godobject_probe                              lists name,params,state,scratch (bytes) of every composition
#include <cstdlib>
#include <iostream>
#include <string>

#include "sim/study/case_run.h"
#include "sim/study/compositions.h"
#include "sim/study/probe/probe_step.h"
#include "tests/oracle/scenes.h"

namespace godobject::study {
namespace {

struct Probe {
  std::string name;
  std::size_t max_bodies, params_bytes, state_bytes, scratch_bytes;
  bool (*run)(std::size_t steps, std::size_t num_bodies);
};

template <Scene S>
bool run(std::size_t steps, std::size_t num_bodies) {
  const oracle::Case problem = oracle::scene_s1();
  CaseRun<S> scene(problem, 1e-3, num_bodies);
  Fault fault = Fault::none;
  for (const Input<S>& in : scene.inputs(steps, 1e9)) {
    probe_step<S>(scene.params(), in, scene.state(), scene.scratch(), scene.output());
    fault |= scene.output().fault;
  }
  return !any(fault);
}

template <Scene S>
Probe probe(const std::string& scene) {
  return {.name = scene + "-" + std::to_string(S::max_bodies) + " " + S::Integrator::name,
          .max_bodies = S::max_bodies,
          .params_bytes = sizeof(Params<S>),
          .state_bytes = sizeof(State<S>),
          .scratch_bytes = sizeof(Scratch<S>),
          .run = run<S>};
}

template <template <class, std::size_t> class SceneOf>
void add(std::vector<Probe>& probes, const std::string& scene) {
  probes.push_back(probe<SceneOf<ImplicitEuler, 1>>(scene));
  probes.push_back(probe<SceneOf<ImplicitEuler, 8>>(scene));
  probes.push_back(probe<SceneOf<TrBdf2, 1>>(scene));
  probes.push_back(probe<SceneOf<TrBdf2, 8>>(scene));
}

std::vector<Probe> all_probes() {
  std::vector<Probe> probes;
  add<Free>(probes, "free");
  add<DeviceOnly>(probes, "device");
  add<Follower>(probes, "pose");
  add<Haptic>(probes, "haptic");
  add<Relative>(probes, "relative");
  add<Admittance>(probes, "admittance");
  return probes;
}

int main(const std::vector<std::string>& arguments) {
  if (arguments.empty()) {
    for (const Probe& p : all_probes())
      std::cout << p.name << ',' << p.params_bytes << ',' << p.state_bytes << ',' << p.scratch_bytes << '\n';
    return 0;
  }
  for (const Probe& p : all_probes()) {
    if (arguments.size() != 3 || p.name != arguments[0]) continue;
    const std::size_t steps = std::stoul(arguments[1]), num_bodies = std::stoul(arguments[2]);
    if (num_bodies < 1 || num_bodies > p.max_bodies) break;
    return p.run(steps, num_bodies) ? 0 : 1;
  }
  std::cerr << "usage: godobject_probe [COMPOSITION STEPS BODIES]\n";
  return 2;
}

}  // namespace
}  // namespace godobject::study

int main(int argc, char** argv) {
  return godobject::study::main(std::vector<std::string>(argv + 1, argv + argc));
}
