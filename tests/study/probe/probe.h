// Interface of a probe program: compositions, each compiled in its own object file, run on motions.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/study/compositions.h"
#include "tests/study/contact/run.h"
#include "tests/study/net/tube.h"
#include "tests/study/probe/probe_step.h"

namespace godobject::study {

struct Probe {
  std::string name;
  std::size_t params_bytes, state_bytes, scratch_bytes;
  bool (*run)(const std::string& motion, std::size_t steps);  // null: only its size is known
};

/// Returns the compositions of the linked program: every_composition.cc or quick_compositions.cc.
std::vector<Probe> probes();

struct ProbeScene {
  bench::ContactScene scene;
  std::size_t steps_before = 0;  // steps before counting begins
};

/// Returns a motion for max_bodies bodies; without bodies for an unknown name.
ProbeScene scene_of(const std::string& motion, std::size_t max_bodies);

/// True if the scene type has all components of the case.
template <Scene S>
bool holds(const oracle::Case& problem) {
  if (problem.bodies.empty() || problem.bodies.size() > S::max_bodies) return false;
  if (!problem.joints.empty() && !uses<typename S::Joints>) return false;
  return !uses<typename S::Device> || problem.bodies[0].coupling.has_value();
}

/// Runs the tube of all nodes that fit, towards the bar and back.
template <Scene S>
bool run_net(const std::string& motion, std::size_t steps) {
  if (motion != "s6") return false;
  TubeRun<S> tube(static_cast<std::uint32_t>(std::lround(std::sqrt(S::Net::max_nodes))));
  tube.restart();
  NetRunning<S>& run = tube.running();
  Fault fault = Fault::none;
  for (std::size_t n = 0; n < steps; ++n) {
    tube.lead();
    probe_step<S>(*run.par, *run.in, *run.x, *run.w, *run.out);
    fault |= run.out->fault;
  }
  return !any(fault);
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

/// Returns a probe with its sizes only.
template <Scene S>
Probe size_of(const std::string& scene) {
  return {.name = scene + "-" + std::to_string(capacity_of<S>()) + " " + S::Integrator::name,
          .params_bytes = sizeof(Params<S>),
          .state_bytes = sizeof(State<S>),
          .scratch_bytes = sizeof(Scratch<S>),
          .run = nullptr};
}

template <Scene S>
Probe probe(const std::string& scene) {
  Probe with_step = size_of<S>(scene);
  if constexpr (uses<NetOf<S>>) with_step.run = run_net<S>;
  else with_step.run = run<S>;
  return with_step;
}

}  // namespace godobject::study
