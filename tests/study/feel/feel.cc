#include "tests/study/feel/feel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include "platform/rig/buses.h"
#include "platform/simulated/session.h"

namespace godobject::study {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

constexpr double metres_per_rad = 0.02;  // of the drive's motor
constexpr double pressed_m = 0.02;       // beyond the touch
constexpr double settled_s = 2;          // engaged, and at rest but for the sine

struct Gains {
  double k_d = FeelTool::k_d, g_d = FeelTool::g_d;
};

/// Motion x = offset - amplitude cos(2 pi f t) of the hand, m.
struct Sine {
  double offset = 0, amplitude = 0, f_Hz = 0;
};

std::string number(double value) {
  std::array<char, 32> digits{};
  std::snprintf(digits.data(), digits.size(), "%.17g", value);
  return digits.data();
}

std::string line(const std::string& key, double value) { return key + " = " + number(value) + "\n"; }

std::string scene_text(const FeelCase& c, const Gains& gains, const Sine& sine) {
  using T = FeelTool;
  std::string s = "[scene]\nname = 'feel'\nabout = 'a tool on a slide'\nintegrator = '" + c.integrator +
                  "'\n" + line("step", c.plan.step_s) + "duration = 60.0\n[[body]]\nname = 'tool'\n" +
                  line("mass", T::mass) +
                  "inertia = [1e-4, 1e-4, 1e-4]\n[[body.sphere]]\nradius = 0.01\n[body.coupling]\n" +
                  line("stiffness", T::k) + line("damping_ratio", c.damping_ratio) +
                  "rotational_stiffness = 1.0\nrotational_damping_ratio = 1.4\n[body.feedback]\n" +
                  line("stiffness", gains.k_d) + line("damping", gains.g_d) +
                  "rotational_stiffness = 0.0\nrotational_damping = 0.0\n";
  if (c.is_pressed)
    s += "[[obstacle]]\nname = 'wall'\nkind = 'box'\nhalf_extents = [0.1, 0.3, 0.3]\n"
         "position = [0.11, 0.0, 0.0]\n[[contact]]\nmaterials = ['default', 'default']\nfriction = 0.0\n" +
         line("stiffness", T::k_wall) + line("damping", T::g_wall);
  s += "[device]\nname = 'slide'\nkind = 'impedance'\n[device.limits]\nforce = 9.0\ntorque = 1.0\n"
       "force_rate = 1e5\ntorque_rate = 1e3\nramp = 0.5\npassivity_control = false\n";
  if (!c.plan.has_buses)
    return s + "[motion]\nposition = [" + number(sine.offset) + ", 0.0, 0.0]\namplitude = [" +
           number(sine.amplitude) + ", 0.0, 0.0]\nfrequency_hz = [" + number(sine.f_Hz) +
           ", 0.0, 0.0]\nphase = [-1.5707963267948966, 0.0, 0.0]\n";
  return s + "[[device.joint]]\nname = 'slide'\nkind = 'slider'\naxis = [1.0, 0.0, 0.0]\n" +
         "[[bus]]\nname = 'can0'\nbit_rate = 1e6\n[device.plant]\ninertia = 0.05\ndamping = 20.0\n" +
         "friction = 0.0\nhand_stiffness = 1e6\nhand_damping = 1e3\n[[device.drive]]\njoint = 'slide'\n" +
         "bus = 'can0'\nnode_id = 1\nprofile = 'generic-402'\ntorque_rated_Nm = 0.00667\ntorque_max_Nm = "
         "0.2\n" +
         "torque_rate_Nm_per_s = 2e3\ncounts_per_unit = 1e6\n" + line("joint_per_motor_rad", metres_per_rad) +
         "status_every_nth_sync = " + std::to_string(c.plan.status_every) +
         "\n[[motion.joint]]\ncoordinate = 'slide'\n" + line("offset", sine.offset) +
         line("amplitude", sine.amplitude) + line("frequency_hz", sine.f_Hz) +
         "phase = -1.5707963267948966\n";
}

/// Sums at one frequency: coordinate at the end of each period, and displayed force.
class LockIn {
 public:
  LockIn(double f_Hz, double step_s) : w_(2 * pi * f_Hz), h_(step_s) {}

  /// Adds x at t, m, and F, N, which was constant over the period up to t (held) or is that at t.
  void add(double t, double x, double F, bool held) {
    X_ += x * std::polar(1.0, -w_ * t);
    const double half = w_ * h_ / 2;
    F_ += F * (held ? std::polar(std::sin(half) / half, half - w_ * t) : std::polar(1.0, -w_ * t));
  }
  Complex ratio() const { return F_ / X_; }

 private:
  double w_, h_;
  Complex X_ = 0, F_ = 0;
};

/// A simulated rig, and its coordinate and force in the last period.
class WatchedLink final : public RigLink {
 public:
  WatchedLink(const SceneConfig& scene, const std::shared_ptr<const Hand>& hand, const RigProfiles& profiles)
      : link_(sim_rig_config(scene), scene.step, hand, gather_time(scene.step) / gather_polls, profiles) {}

  std::span<CanBus* const> buses() noexcept override { return link_.buses(); }
  Nanoseconds begin_cycle(double motion_time) noexcept override {
    const Nanoseconds t = link_.begin_cycle(motion_time);
    x = link_.rig().joints().q[0];
    F = -link_.rig().applied_torque_Nm(0) / metres_per_rad;
    return t;
  }
  Nanoseconds wait(Nanoseconds until) noexcept override { return link_.wait(until); }
  void set_observer(const BusObserver& observer) noexcept override { link_.set_observer(observer); }

  double x = 0, F = 0;  // m; N, which the hand must exert against the drive

 private:
  SimLink link_;
};

[[noreturn]] void fail(const std::vector<std::string>& errors) {
  std::string all;
  for (const std::string& error : errors) all += (all.empty() ? "" : "; ") + error;
  throw std::runtime_error(all);
}

/// Runs the session, and calls use(t, x, F) after each period from settled_s on.
template <class Use>
void run_sine(const FeelCase& c, const Gains& gains, const Sine& sine, double duration_s, const Use& use) {
  LoadResult loaded = parse_scene(scene_text(c, gains, sine), "feel");
  if (!loaded.scene) fail(loaded.errors);
  SceneConfig scene = *std::move(loaded.scene);
  std::vector<std::string> errors;
  Motion motion(scene);
  const WatchedLink* watched = nullptr;
  Session::Made made;
  if (c.plan.has_buses) {
    const RigProfiles profiles = checked_profiles(scene, "feel", errors);
    if (!errors.empty()) fail(errors);
    auto link = std::make_unique<WatchedLink>(scene, hand_of(motion), profiles);
    watched = link.get();
    made = Session::make(std::move(scene), std::move(motion), std::move(link));
  } else {
    made = Session::make(std::move(scene), std::move(motion));
  }
  if (!made.session) fail(made.errors);
  Session& session = *made.session;
  if (!session.boot(usual_boot_limit_s)) fail({"the rig does not come up"});
  CycleRecord record = session.at_start();
  while (record.t < settled_s + duration_s - c.plan.step_s / 2) {
    session.cycle(record);
    if (record.fault != Fault::none || record.rig_faults != RigFault::none) fail({"a fault in the session"});
    if (record.t < settled_s + c.plan.step_s / 2) continue;
    const BodyView& tool = record.bodies[0];
    if (watched) use(record.t, watched->x, watched->F);
    else use(record.t, tool.target.X_WD.p.x(), -tool.feedback_D.f.x());
  }
}

Felt measure(const FeelCase& c, const Gains& gains, double f_Hz) {
  const double w = 2 * pi * f_Hz;
  const Sine sine{.offset = c.is_pressed ? pressed_m : 0,
                  .amplitude = std::min(c.is_pressed ? 0.005 : 0.1, 40 / (w * w)),
                  .f_Hz = f_Hz};
  const double periods = std::ceil(std::max(2.0, f_Hz));  // at least a second
  LockIn lock_in(f_Hz, c.plan.step_s);
  run_sine(c, gains, sine, periods / f_Hz,
           [&](double t, double x, double F) { lock_in.add(t, x - sine.offset, F, c.plan.has_buses); });
  return {.f_Hz = f_Hz, .Z = lock_in.ratio()};
}

Felt by_law(const FeelCase& c, const Gains& gains, double f_Hz) {
  using T = FeelTool;
  const double w = 2 * pi * f_Hz;
  const Complex jw(0, w);
  // m x_B'' = k (x - x_B) + g (x' - x_B') - k_wall x_B - g_wall x_B'
  const double g = c.damping_ratio * std::sqrt(T::k * T::mass);
  const Complex coupling = T::k + jw * g, wall = c.is_pressed ? T::k_wall + jw * T::g_wall : Complex(0);
  const Complex tool_per_hand = coupling / (coupling + wall - w * w * T::mass);
  const Complex direct = (gains.k_d + jw * gains.g_d) * (1.0 - tool_per_hand);
  if (!c.plan.has_buses) return {.f_Hz = f_Hz, .Z = direct};
  const double half = w * c.plan.step_s / 2;
  const double delay_s = c.plan.step_s * (1.5 + 0.5 * (c.plan.status_every - 1));  // mean age of the position
  return {.f_Hz = f_Hz, .Z = direct * std::polar(std::sin(half) / half, -w * delay_s)};
}

}  // namespace

std::vector<FeelPlan> feel_plans() {
  return {{.name = "direct"},
          {.name = "bus-1kHz", .has_buses = true},
          {.name = "bus-1kHz-2nd-sync", .has_buses = true, .status_every = 2},
          {.name = "bus-500Hz", .has_buses = true, .step_s = 2e-3}};
}

double Felt::mass() const {
  const double w = 2 * pi * f_Hz;
  return -Z.real() / (w * w);
}

double Felt::damping() const { return Z.imag() / (2 * pi * f_Hz); }

std::vector<double> feel_frequencies(int per_decade) {
  std::vector<double> frequencies;
  for (int i = 0; i <= 3 * per_decade; ++i) {
    const double period_s = 0.002 * std::round(std::pow(10, 1 - static_cast<double>(i) / per_decade) / 0.002);
    frequencies.push_back(1 / period_s);
  }
  return frequencies;
}

Felt measure_feel(const FeelCase& c, double f_Hz) { return measure(c, {}, f_Hz); }

Felt feel_by_law(const FeelCase& c, double f_Hz) { return by_law(c, {}, f_Hz); }

double drag_of(const FeelCase& c) {
  const double f_Hz = 0.1;
  double largest = 0;
  run_sine(c, {}, {.amplitude = 0.2 / (2 * pi * f_Hz), .f_Hz = f_Hz}, 1 / f_Hz,
           [&](double, double, double F) { largest = std::max(largest, std::abs(F)); });
  return largest;
}

double delay_of(const FeelPlan& plan) {
  constexpr double f_Hz = 1;
  constexpr Gains spring{.g_d = 0};
  const Felt felt = measure({.plan = plan, .is_pressed = true}, spring, f_Hz);
  const Felt at_once = by_law({.plan = {}, .is_pressed = true}, spring, f_Hz);
  return -std::arg(felt.Z / at_once.Z) / (2 * pi * f_Hz);
}

}  // namespace godobject::study
