// godobject_probe, godobject_quick_probe: runs steps of one composition under callgrind.
//   godobject_probe COMPOSITION STEPS MOTION     runs, e.g. godobject_probe "haptic-1 tr-bdf2" 500 s1
//   godobject_probe                              lists name,params,state,scratch (bytes) of every composition
//
// Motions without contacts: s1, s1-full (as many bodies as fit), s3, s5 (as many links as fit), pair-free and
// pair-<kind of joint>. Each also exists as <motion>-slow, smaller and slower, with the same number of
// instructions if they do not depend on the data. With contacts: s2, s2-smooth (without friction) and s4, run
// to full contact before the requested steps; with a net: s6.
#include <cstdlib>
#include <iostream>
#include <optional>

#include "tests/study/joint/scene.h"
#include "tests/study/probe/probe.h"

namespace godobject::study {
namespace {

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

/// Returns the case of a motion; empty for an unknown motion.
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

constexpr double pressing_stiffness = 1e4;  // N/m, for S2

}  // namespace

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

namespace {

int main(const std::vector<std::string>& arguments) {
  if (arguments.empty()) {
    for (const Probe& p : probes())
      std::cout << p.name << ',' << p.params_bytes << ',' << p.state_bytes << ',' << p.scratch_bytes << '\n';
    return 0;
  }
  for (const Probe& p : probes())
    if (arguments.size() == 3 && p.run && p.name == arguments[0])
      return p.run(arguments[2], std::stoul(arguments[1])) ? 0 : 1;
  std::cerr << "usage: godobject_probe [COMPOSITION STEPS MOTION]\n";
  return 2;
}

}  // namespace
}  // namespace godobject::study

int main(int argc, char** argv) {
  return godobject::study::main(std::vector<std::string>(argv + 1, argv + argc));
}
