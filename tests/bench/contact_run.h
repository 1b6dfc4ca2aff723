// A scene with contacts in the core.
#pragma once

#include <stdexcept>

#include "tests/bench/bench.h"
#include "tests/bench/contact_quality.h"
#include "tests/bench/peer/native_peers.h"
#include "tests/study/contact/run.h"

namespace godobject::bench {

template <Scene S>
class ContactRun {
 public:
  /// Keeps references to both. Throws std::invalid_argument for parameters that validate() refuses.
  ContactRun(const ContactScene& scene, const Targets& targets)
      : scene_(scene), targets_(targets), run_(scene.problem, h) {
    study::set_contacts(scene, run_.params());
    if (validate(run_.params()) != Invalid::nothing)
      throw std::invalid_argument(scene.name + ": invalid parameters");
    for (std::size_t i = 1; i < scene.problem.bodies.size(); ++i) in_.devices[i].engaged = false;
  }

  void restart() { run_.restart(); }

  void step(std::size_t n) noexcept {
    const oracle::RigidState& D = targets_[n + 1].front();
    study::set_input(D, D, in_.devices[0]);
    run_.step(in_);
  }

  /// Throws std::runtime_error for a fault of the last step.
  Snapshot snapshot() {
    if (any(run_.output().fault)) throw std::runtime_error(scene_.name + ": the step reported a fault");
    Snapshot now;
    now.num_contacts = run_.output().contacts.num_contacts;
    for (std::size_t i = 0; i < scene_.problem.bodies.size(); ++i)
      now.bodies.push_back(study::oracle_state(run_.body(i)));
    return now;
  }

 private:
  const ContactScene& scene_;
  const Targets& targets_;
  study::CaseRun<S> run_;
  Input<S> in_;
};

}  // namespace godobject::bench
