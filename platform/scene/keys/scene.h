// All keys of a scene file with name, unit, range, meaning and member. Keys below [device], [[joint]] and of
// contacts have files of their own. Visitors: platform/scene/text/key.h.
#pragma once

#include <cmath>
#include <set>

#include <Eigen/Eigenvalues>

#include "platform/scene/checks.h"
#include "platform/scene/keys/contact.h"
#include "platform/scene/keys/device.h"
#include "platform/scene/keys/hand.h"
#include "platform/scene/keys/joint.h"
#include "platform/scene/keys/net.h"
#include "platform/scene/keys/term.h"
#include "platform/scene/scene.h"
#include "platform/scene/text/key.h"
#include "platform/scene/toml.h"

namespace godobject {

inline constexpr double default_damping_ratio = 1.4;  // the paper: 1.4 <= g / sqrt(m k) <= 2
inline constexpr double min_advised_ratio = 1.4, max_advised_ratio = 2.0;
inline constexpr double max_advised_step = 2e-3;  // s

/// Keys of a [[fault]] table, in scenes and in files of their own. device: null for none.
template <class V>
void visit_fault(V& v, const DeviceConfig* device, const FaultChecks& checks, FaultConfig& f) {
  if (f.verb.empty()) f.verb = "drop";
  const Key verb{.name = "verb", .unit = "", .meaning = "see docs/faults.md", .required = true};
  if (checks.verbs == nullptr) v.value(verb, f.verb);
  else choose(v, verb, checks.verbs(), f.verb);
  v.value(Key{"bus", "", "empty: the node's; without a node all"}, f.bus);
  std::uint8_t node_id = f.node_id.value_or(0);
  v.value(Key{"node_id", "", "0: the host's end of the bus", {0, 127}}, node_id);
  f.node_id = node_id == 0 ? std::nullopt : std::optional(node_id);
  v.value(Key{"tracker", "", "instead of bus and node"}, f.tracker);
  v.value(Key{"at", "s", "time of the motion; at 0 it is active from booting", {0, 1e6}}, f.at);
  v.value(Key{"duration",
              "s",
              "default: to the end, or once for an event",
              {.min = 0, .max = 1e6, .min_open = true}},
          f.duration);
  v.value(Key{"value", "", "unit in docs/faults.md; 0: the verb's default"}, f.value);
  const bool has_place = device && (device->rig || !f.tracker.empty());
  v.check(has_place, "verb", "requires a [device] with buses, or a tracker: add one, or remove the fault");
  if (!has_place || checks.why_not_playable == nullptr) return;
  const std::string error = checks.why_not_playable(f, *device);
  v.check(error.empty(), "verb", "'" + f.verb + "' cannot be played: " + error);
}

/// Mass and inertia that define damping ratios: g = ratio sqrt(m k), g_r = ratio sqrt(I_max k_r).
struct Massiveness {
  double mass = 1;     // kg
  double inertia = 1;  // largest principal moment, kg m^2
};

inline double critical(double mass, double stiffness) { return std::sqrt(mass * stiffness); }

template <class V>
void advise_ratio(V& v, std::string_view key, double damping, double critical_damping) {
  const double ratio = critical_damping > 0 ? damping / critical_damping : default_damping_ratio;
  constexpr double rounding = 1e-6;
  v.advise(ratio >= min_advised_ratio - rounding && ratio <= max_advised_ratio + rounding, key,
           "damping ratio " + shortest(ratio) + " is outside the advised range " +
               to_string(Range{min_advised_ratio, max_advised_ratio}));
}

/// Visits the four gains. A gain that is not given keeps its value, or has the damping ratio `ratio` if this
/// is set.
template <class V>
void visit_gains(V& v, const Massiveness& body, std::optional<double> ratio, SpringParams& c) {
  const auto fallback = [&](double unit, double gain) { return ratio ? *ratio * unit : gain; };
  const bool required = ratio.has_value();
  v.value(Key{"stiffness", "N/m", "translational stiffness k", {0, 1e13}, required}, c.k);
  const double g_unit = critical(body.mass, c.k);
  v.either(Key{"damping", "N s/m", "translational damping g", not_negative},
           Key{"damping_ratio", "", "g / sqrt(m k), default 1.4, advised 1.4 to 2", {0, 1e3}}, g_unit,
           fallback(g_unit, c.g), c.g);
  v.value(Key{"rotational_stiffness", "N m/rad", "rotational stiffness k_r", {0, 1e13}, required}, c.k_r);
  const double g_r_unit = critical(body.inertia, c.k_r);
  v.either(Key{"rotational_damping", "N m s/rad", "rotational damping g_r", not_negative},
           Key{"rotational_damping_ratio", "", "g_r / sqrt(I_max k_r), the same", {0, 1e3}}, g_r_unit,
           fallback(g_r_unit, c.g_r), c.g_r);
}

template <class V>
void visit_coupling(V& v, const Massiveness& body, SpringParams& c) {
  visit_gains(v, body, default_damping_ratio, c);
  advise_ratio(v, "damping", c.g, critical(body.mass, c.k));
  advise_ratio(v, "rotational_damping", c.g_r, critical(body.inertia, c.k_r));
}

template <class V>
void visit_feedback(V& v, const Massiveness& body, const SpringParams& coupling, SpringParams& f) {
  double scale = 0;
  v.shorthand(Key{"scale",
                  "",
                  "factor of the coupling's stiffnesses, where none is given here; not of damping, which "
                  "requires as much in the device",
                  {0, 1e3}},
              scale);
  if (scale > 0) f = {.k = scale * coupling.k, .k_r = scale * coupling.k_r};
  if constexpr (requires { v.keys_of("", "", ""); })
    return v.keys_of("[body.coupling]", "stiffness", "rotational_damping_ratio");
  visit_gains(v, body, std::nullopt, f);
}

/// Copies the body named by `like`, with numbers for its ratios, except name, pose and velocity.
template <class V>
void visit_like(V& v, const std::vector<BodyConfig>& bodies, BodyConfig& b) {
  std::string like;
  v.shorthand(Key{"like", "",
                  "earlier body, whose keys are copied where missing (a damping ratio as its damping), "
                  "except name, pose and velocity; a list of tables as a whole"},
              like);
  if (like.empty()) return;
  const auto earlier = std::ranges::find_if(
      bodies, [&](const BodyConfig& other) { return &other != &b && other.name == like; });
  v.check(earlier != bodies.end(), "like",
          "is \"" + like + "\", which is not an earlier body: name a body above this one");
  if (earlier == bodies.end()) return;
  const std::string name = b.name;
  b = *earlier;
  b.name = name;
  b.X_WB = {};
  b.is_placed = false;
  b.V_WB = {};
}

template <class V>
void visit_body(V& v, const std::vector<BodyConfig>& bodies, BodyConfig& b) {
  visit_name(v, "name, in columns of traces and motions", b.name);
  visit_like(v, bodies, b);
  const bool own = !v.has("like");
  v.value(Key{"mass", "kg", "", mass_of_body, own}, b.mass);
  v.inertia(Key{"inertia", "kg m^2", "about the centre of mass, body axes", any_number, own}, b.inertia);
  visit_pose(v, "position", "orientation_wxyz", "the centre of mass at t = 0", b.X_WB);
  b.is_placed = b.is_placed || v.has("position") || v.has("orientation_wxyz");
  v.value(Key{"velocity", "m/s", "at t = 0"}, b.V_WB.v);
  v.value(Key{"angular_velocity", "rad/s", "at t = 0"}, b.V_WB.w);
  const double I_max = b.inertia.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
  const Massiveness body{b.mass, I_max};
  optional_table(v, TableKey{"coupling", "Spring and damper to the target; without it the body is free."},
                 b.coupling, [&](auto& t, SpringParams& c) { visit_coupling(t, body, c); });
  optional_table(
      v,
      TableKey{"feedback",
               "Spring and damper of the displayed wrench, 0 by default; without it there is none."},
      b.feedback, [&](auto& t, SpringParams& f) {
        t.check(b.coupling.has_value(), "", "feedback requires a coupling: add [body.coupling]");
        visit_feedback(t, body, b.coupling.value_or(SpringParams{}), f);
      });
  visit_spheres_and_shapes(v, b);
  const auto doubt = [&](std::string_view key, const std::string& text) {
    v.advise(text.empty(), key, text);
  };
  doubt("inertia", doubt_of_gyration(b));
  doubt("mass", doubt_of_density(b));
}

template <class V>
void visit_header(V& v, SceneConfig& s) {
  visit_name(v, "", s.name);
  v.value(Key{"about", "", "purpose in one line"}, s.about);
  v.value(Key{"step", "s", "step h, and period of the loop", {1e-6, 0.1}}, s.step);
  v.advise(s.step <= max_advised_step, "step",
           "is above 2 ms: the hand feels the delay, and feedback gains must be low; use a shorter step");
  v.value(Key{"duration", "s", "of a run without --duration", {.min = 0, .max = 1e6, .min_open = true}},
          s.duration);
  choose(v,
         Key{.name = "integrator",
             .unit = "",
             .meaning = "`\"implicit-euler\"` or `\"tr-bdf2\"`",
             .otherwise = "`\"tr-bdf2\"`, among touching bodies `\"implicit-euler\"`"},
         {integrator_names.begin(), integrator_names.end()}, s.integrator);
  choose(v,
         Key{"coupling", "",
             "god-object: [body.coupling] pulls; imposed, for comparisons: bodies are placed at their "
             "targets, through anything"},
         coupling_names, s.coupling);
  v.value(Key{"gravity", "m/s^2", ""}, s.gravity);
  v.value(Key{"net_iterations",
              "",
              "most conjugate gradients in a net stage; residual: `residual_N` of the report",
              {1, 1000}},
          s.net_iterations);
}

template <class V>
void visit_coordinate_motion(V& v, const std::vector<std::string>& device_joints, CoordinateMotion& m) {
  choose(v, Key{.name = "coordinate", .unit = "", .meaning = "joint of the device", .required = true},
         device_joints, m.coordinate);
  v.value(Key{"offset", "rad or m", "q_0 of q = q_0 + A sin(2 pi f t + phase)"}, m.offset);
  v.value(Key{"amplitude", "rad or m", "A"}, m.amplitude);
  v.value(Key{"frequency_hz", "Hz", "f", {0, 1e3}}, m.frequency_hz);
  v.value(Key{"phase", "rad", ""}, m.phase);
}

template <class V>
void visit_motion(V& v, const SceneConfig& scene, const std::vector<std::string>& device_joints,
                  MotionConfig& m) {
  v.value(Key{"amplitude", "m", "A of p = p_0 + A sin(2 pi f t + phase)"}, m.amplitude);
  v.value(Key{"frequency_hz", "Hz", "f", {0, 1e3}}, m.frequency_hz);
  v.value(Key{"phase", "rad", ""}, m.phase);
  v.value(Key{"angle_amplitude", "rad", "the same of angles about z, y, x: q = q_0 qz qy qx"},
          m.angle_amplitude);
  v.value(Key{"angle_frequency_hz", "Hz", "", {0, 1e3}}, m.angle_frequency_hz);
  v.value(Key{"angle_phase", "rad", ""}, m.angle_phase);
  visit_pose(v, "position", "orientation_wxyz", "p_0, q_0", m.X_WD);
  v.value(Key{"force_amplitude", "N", "admittance devices: the hand's force, f and phase as of p"},
          m.force_amplitude);
  v.value(Key{"torque_amplitude", "N m", "the same"}, m.torque_amplitude);
  std::set<std::string> moved;
  v.tables(TableKey{"joint", "Motion of a joint of the device, instead of the target's. Others rest at 0."},
           m.joints, [&](auto& t, CoordinateMotion& q) {
             visit_coordinate_motion(t, device_joints, q);
             t.check(moved.insert(q.coordinate).second, "coordinate", "has an earlier table");
           });
  visit_holds(v, scene, m.holds);
  v.check(m.joints.empty() || (m.amplitude.isZero(0) && m.angle_amplitude.isZero(0)), "joint",
          "moves the device: remove 'amplitude' and 'angle_amplitude', which move the first target");
}

template <class V>
void visit_wire(V& v, WireConfig& w) {
  v.value(Key{"seed", "", "", {0, 9007199254740992.0}}, w.seed);
  v.value(Key{"loss_probability", "", "", probability}, w.loss_probability);
  v.value(Key{"corruption_probability", "", "the frame is sent again", probability},
          w.corruption_probability);
  v.value(Key{"delay", "s", "of every frame", {0, 1}}, w.delay_s);
}

inline std::vector<std::string> device_joints(const SceneConfig& s) {
  std::vector<std::string> names;
  if (const KinematicTreeParams* const tree = device_tree(s))
    for (const DeviceJoint& joint : tree->joints) names.push_back(joint.name);
  return names;
}

/// Removes the tool's joints from a device that grips bodies, since it has one handle, unless a motion moves
/// them.
inline void drop_idle_tree(SceneConfig& s) {
  if (!grips_bodies(s) || !s.device->unmeasured_tree) return;
  const bool moved = s.motion && !s.motion->joints.empty();
  if (!moved && s.device->unmeasured_tree->handles.size() > 1) s.device->unmeasured_tree.reset();
}

/// Checks that the device has the coordinates of prescribed joints.
template <class V>
void check_prescribed_joints(V& v, const SceneConfig& s) {
  const std::vector<std::string> of_device = device_joints(s);
  for (const JointConfig& joint : s.joints) {
    if (!joint.prescribed) continue;
    v.check(device_tree(s) != nullptr, "joint",
            "'" + joint.name + "' is imposed and requires a [device] with joints: add one");
    if (device_tree(s) == nullptr) continue;
    for (const std::string& q : joint.coordinates)
      v.check(std::ranges::find(of_device, q) != of_device.end(), "joint",
              "'" + joint.name + "' is imposed, but the device has no joint '" + q + "': it has " +
                  quoted(of_device));
  }
}

template <class V>
void check_coupling_mode(V& v, const SceneConfig& s) {
  if (s.coupling != CouplingMode::imposed) return;
  const bool gives_a_pose = !(s.device && s.device->kind == DeviceKind::admittance);
  v.check(gives_a_pose, "scene",
          "has coupling \"imposed\", but a device of kind \"admittance\" has no pose for the bodies: use "
          "\"god-object\"");
  v.check(std::ranges::any_of(s.bodies, [](const BodyConfig& b) { return b.coupling.has_value(); }), "scene",
          "has coupling \"imposed\" and no body to place: add [body.coupling] to one");
}

/// Checks rules between tables.
template <class V>
void check_scene(V& v, const SceneConfig& s) {
  const auto coupled = [](const BodyConfig& b) { return b.coupling.has_value(); };
  check_prescribed_joints(v, s);
  check_coupling_mode(v, s);
  check_holding(v, s);
  const auto with_feedback = [](const BodyConfig& b) { return b.feedback.has_value(); };
  if (!s.device) return;
  const bool feedback = std::ranges::any_of(s.bodies, with_feedback);
  v.check(s.device->kind == DeviceKind::admittance || std::ranges::any_of(s.bodies, coupled), "device",
          "drives no body: add [body.coupling] to the body that it moves");
  v.check(
      s.device->kind != DeviceKind::non_haptic || !feedback, "device",
      "of kind \"non-haptic\" cannot display a wrench: remove [body.feedback], or use kind \"impedance\"");
  v.advise(!feedback || !s.device->rig || !s.device->rig->drives.empty(), "device",
           "has no [[device.drive]]: the feedback is computed but not displayed; add drives, or remove "
           "[body.feedback]");
}

template <class V>
void visit_scene(V& v, SceneConfig& s, const FaultChecks& checks) {
  plain_table(v, TableKey{"scene", "The scene.", true}, [&](auto& t) { visit_header(t, s); });
  std::set<std::string> names;
  v.tables(
      TableKey{"body", "A rigid body.", true, max_tables_of_bodies}, s.bodies, [&](auto& t, BodyConfig& b) {
        visit_body(t, s.bodies, b);
        t.check(names.insert(b.name).second, "name", "is the name of an earlier body");
        t.check(b.name != world_name, "name", "is the name of the ground in joints: choose another name");
      });
  visit_tool_joints(v, s);
  visit_terms(v, s);
  visit_nets(v, s);
  visit_contacts(v, s);
  std::vector<BusParams> buses = s.device && s.device->rig ? s.device->rig->buses : std::vector<BusParams>{};
  std::set<std::string> bus_names;
  v.tables(TableKey{"bus", "A CAN bus."}, buses, [&](auto& t, BusParams& b) {
    visit_name(t, "", b.name);
    t.check(bus_names.insert(b.name).second, "name", "is the name of an earlier bus");
    t.value(Key{"bit_rate", "bit/s", "arbitration phase", {1e4, 1e6}}, b.bit_rate);
    t.value(Key{"data_bit_rate", "bit/s", "data phase of CAN FD; 0: classic bus", {0, 8e6}}, b.data_bit_rate);
    t.check(b.data_bit_rate == 0 || b.data_bit_rate >= b.bit_rate, "data_bit_rate",
            "is below bit_rate: must be 0, or bit_rate and above");
  });
  optional_table(v, TableKey{"device", "The device that drives coupled bodies, and its rig."}, s.device,
                 [&](auto& t, DeviceConfig& d) { visit_device(t, s, buses, d); });
  optional_table(v, TableKey{"motion", "Motion of the target without `--motion`."}, s.motion,
                 [&](auto& t, MotionConfig& m) { visit_motion(t, s, device_joints(s), m); });
  drop_idle_tree(s);
  plain_table(v, TableKey{"wire", "Random faults of simulated buses."},
              [&](auto& t) { visit_wire(t, s.wire); });
  v.tables(
      TableKey{
          "fault",
          "A fault that the simulated rig plays ([faults](faults.md#faults-that-the-simulated-rig-plays)).",
          false, 10'000},
      s.faults, [&](auto& t, FaultConfig& f) { visit_fault(t, s.device ? &*s.device : nullptr, checks, f); });
  check_scene(v, s);
}

}  // namespace godobject
