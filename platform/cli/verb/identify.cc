// godobject identify: moves the joints of a device and prints their mechanics as keys of [device].
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <memory>

#include "hal/rig/excitation.h"
#include "platform/cli/command_line.h"
#include "platform/cli/program.h"
#include "platform/rig/run.h"
#include "platform/scene/text/diagnostics.h"

namespace godobject {
namespace {

struct IdentifyOptions {
  std::string scene;
  std::vector<std::string> buses, joints;
  double period_s = 2, torque = 0.5;
  int cycles = 3;
  bool hand_on_the_stop = false;
};

ExitCode refuse(const std::vector<std::string>& errors, ExitCode code) {
  for (const std::string& error : errors) std::fprintf(stderr, "%s\n", error.c_str());
  return code;
}

/// Reads NAME=AMPLITUDE of each joint. Returns the errors.
std::vector<std::string> read_joints(const IdentifyOptions& options, const RigParams& rig,
                                     ExcitationParams& params) {
  std::vector<std::string> errors;
  for (const std::string& text : options.joints) {
    const std::size_t split = text.find('=');
    const std::string name = text.substr(0, split),
                      number = split == std::string::npos ? "" : text.substr(split + 1);
    const auto joint = std::ranges::find(rig.tree.joints, name, &DeviceJoint::name);
    double amplitude = 0;
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), amplitude);
    if (joint == rig.tree.joints.end())
      errors.push_back("--joint " + text + ": the device's joints are " + quoted_names(rig.tree.joints));
    else if (error != std::errc{} || end != number.data() + number.size() ||
             !(amplitude > 0 && amplitude < 10))
      errors.push_back("--joint " + text + ": give NAME=AMPLITUDE, in rad or m, above 0 and below 10");
    if (!errors.empty()) continue;
    const auto index = static_cast<std::size_t>(joint - rig.tree.joints.begin());
    if (std::ranges::count(params.joints, index) > 0)
      errors.push_back("--joint " + name + ": is given twice");
    params.joints.push_back(index);
    params.amplitude.push_back(amplitude);
  }
  return errors;
}

void print(const Identification& found, const SceneConfig& scene) {
  const std::vector<DeviceJoint>& joints = scene.device->rig->tree.joints;
  for (const IdentifiedJoint& joint : found.joints) {
    std::printf("[[device.plant.joint]]\njoint = \"%s\"\n", joints[joint.joint].name.c_str());
    const auto key = [](const char* name, const Estimate& of) {
      std::printf("%s = %.4g  # +- %.2g\n", name, of.value, of.error);
    };
    key("inertia", joint.inertia);
    key("damping", joint.damping);
    key("friction", joint.friction);
    std::printf("# unexplained: %.2g of a torque of %.2g, root mean square\n\n", joint.residual_rms,
                joint.torque_rms);
  }
  for (const IdentifiedJoint& joint : found.joints) {
    if (!joint.has_weight) continue;
    const bool hinge = joints[joint.joint].kind == DeviceJointKind::hinge;
    std::printf("# into the [[device.joint]] \"%s\", for [device.compensation] gravity:\n",
                joints[joint.joint].name.c_str());
    std::printf("mass = %.4g%s", joint.mass,
                hinge ? "  # only mass times lever is determined: +- " : "  # +- ");
    std::printf("%.2g%s\n", joint.weight_error, hinge ? " kg m" : "");
    std::printf("center_of_mass = [%.4g, %.4g, %.4g]\n\n", joint.p_LM.x(), joint.p_LM.y(), joint.p_LM.z());
  }
  if (scene.device->plant.gravity_W.isZero())
    std::printf("# no weights: the scene has no gravity in [device.plant]\n");
}

/// Runs the excitation on the rig. Returns the reasons why its record must not be used.
std::vector<std::string> excite(RigRun& run, Excitation& excitation) {
  const SceneConfig& scene = run.scene();
  const std::vector<std::size_t> driven = driven_bodies(scene);
  std::vector<std::size_t> bodies;  // by handle
  for (const std::optional<std::size_t>& target : driven_by_handles(scene)) bodies.push_back(driven[*target]);
  std::array<Wrench, max_handles> F;
  const RigRun::Result result = run.run([&](std::span<const BodySample> samples, std::span<Wrench> F_hand_W) {
    const bool valid = std::ranges::all_of(bodies, [&](std::size_t body) { return samples[body].valid; });
    F = {};
    const bool goes_on =
        excitation.step(run.device().rig(), run.device().q(), valid, std::span(F).first(bodies.size()));
    for (std::size_t h = 0; h < bodies.size(); ++h) F_hand_W[bodies[h]] = F[h];
    return goes_on;
  });
  std::vector<std::string> errors;
  if (!result.signal.empty()) errors.push_back("interrupted by " + result.signal);
  for (const std::string& text : {result.why_not, result.faults})
    if (!text.empty()) errors.push_back(text.substr(0, text.find_last_not_of('\n') + 1));
  if (errors.empty() && !excitation.why_not().empty()) errors.push_back(excitation.why_not());
  return errors;
}

ExitCode identify(const IdentifyOptions& options) {
  if (!options.hand_on_the_stop)
    return refuse(
        {"this verb moves every joint that is named: give --hand-on-the-stop once you see the whole rig "
         "and have your hand on its emergency stop"},
        ExitCode::usage);
  RigRun run(options.scene, options.buses);
  if (!run.errors().empty()) return refuse(run.errors(), ExitCode::usage);
  const RigParams& rig = *run.scene().device->rig;
  ExcitationParams params{.joints = {},
                          .amplitude = {},
                          .period_s = options.period_s,
                          .cycles = options.cycles,
                          .torque = options.torque};
  std::vector<std::string> errors = read_joints(options, rig, params);
  if (errors.empty()) errors = Excitation::complaints(rig, params);
  if (!errors.empty()) return refuse(errors, ExitCode::usage);
  const PlantConfig& plant = run.scene().device->plant;
  Excitation excitation(rig, plant, run.step_s(), params);
  std::fprintf(stderr, "moves %zu joints for %.0f s; a device without brakes falls when it ends\n",
               params.joints.size(), excitation.duration_s());
  errors = excite(run, excitation);
  if (!errors.empty()) return refuse(errors, ExitCode::fault);
  const Identification found = godobject::identify(
      {.tree = rig.tree, .gravity_W = plant.gravity_W, .period_s = run.step_s()}, excitation.records());
  if (!found.errors.empty()) return refuse(found.errors, ExitCode::fault);
  print(found, run.scene());
  return ExitCode::ok;
}

}  // namespace

void add_identify(CLI::App& app, ExitCode& code) {
  CLI::App* verb = app.add_subcommand(
      "identify",
      "Move the joints of a device by slow sines and print inertia, damping, friction and weights.");
  const auto options = std::make_shared<IdentifyOptions>();
  verb->add_option("SCENE", options->scene, "read the device from this scene file (TOML)")->required();
  verb->add_option("--bus", options->buses, "open this bus: ADDRESS or NAME=ADDRESS, as for `run`")
      ->type_name("BUS")
      ->required()
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  verb->add_option(
          "--joint", options->joints,
          "move this joint by the amplitude, rad or m; once for each joint. The others are held. The run "
          "ends if a joint leaves three amplitudes")
      ->type_name("NAME=AMPLITUDE")
      ->required()
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  verb->add_option("--period", options->period_s, "set the period of the slow sine, s; a fast one follows")
      ->check(number_in(0.2, 60))
      ->capture_default_str();
  verb->add_option("--cycles", options->cycles, "set the number of slow cycles of each joint")
      ->check(CLI::Range(2, 100))
      ->capture_default_str();
  verb->add_option("--torque", options->torque, "use at most this share of the drives' torque_max_Nm")
      ->check(number_in(0.01, 1))
      ->capture_default_str();
  verb->add_flag("--hand-on-the-stop", options->hand_on_the_stop,
                 "confirm that you see the whole rig and have your hand on its emergency stop; required");
  verb->callback([options, &code] { code = identify(*options); });
}

}  // namespace godobject
