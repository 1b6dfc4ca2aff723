#include "tests/study/feel/feel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
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
         "[[bus]]\nname = 'can0'\nbit_rate = 1e6\n[device.plant]\n" + line("inertia", FeelDevice::mass) +
         line("damping", FeelDevice::damping) +
         "friction = 0.0\nhand_stiffness = 1e6\nhand_damping = 1e3\n[[device.drive]]\njoint = 'slide'\n" +
         "bus = 'can0'\nnode_id = 1\nprofile = 'generic-402'\ntorque_rated_Nm = 0.00667\ntorque_max_Nm = "
         "0.2\n" +
         "torque_rate_Nm_per_s = 2e3\n" + line("counts_per_unit", 1 / c.plan.count_m) +
         line("joint_per_motor_rad", metres_per_rad) +
         "status_every_nth_sync = " + std::to_string(c.plan.status_every) +
         "\n[[motion.joint]]\ncoordinate = 'slide'\n" + line("offset", sine.offset) +
         line("amplitude", sine.amplitude) + line("frequency_hz", sine.f_Hz) +
         "phase = -1.5707963267948966\n";
}

/// State at the end of a period: time, s; coordinate, m; forces, N.
struct Moment {
  double t = 0, x = 0;
  double F = 0;                      // displayed, which the hand must exert against the drive
  std::span<const double> F_hand{};  // of the hand in each sub-step of the mechanics; empty without buses
};

constexpr double substep_s = 1e-9 * static_cast<double>(SimPlant::substep_ns);

/// Sums at one frequency: coordinate at the end of each period, and forces.
class LockIn {
 public:
  /// holds: the displayed force was constant over the period up to t; else it is that at t.
  LockIn(double f_Hz, double step_s, bool holds)
      : f_Hz_(f_Hz),
        w_(2 * pi * f_Hz),
        held_(holds ? std::polar(std::sin(w_ * step_s / 2) / (w_ * step_s / 2), w_ * step_s / 2) : 1) {}

  void add(const Moment& at) {
    const Complex turn = std::polar(1.0, -w_ * at.t);
    X_ += at.x * turn;
    F_ += at.F * turn;
    double t = at.t;
    for (std::size_t i = at.F_hand.size(); i-- > 0; t -= substep_s)
      F_own_ += (at.F_hand[i] - at.F) / static_cast<double>(at.F_hand.size()) * std::polar(1.0, -w_ * t);
    sum_ += at.F;
    sum_of_squares_ += at.F * at.F;
    ++num_;
  }
  /// Returns the result over whole periods of the sine.
  Felt felt() const {
    const Complex displayed = F_ * held_ / X_, own = F_own_ / X_;
    const double mean = sum_ / num_, sine = std::numbers::sqrt2 * std::abs(F_) / num_;
    const double rest = sum_of_squares_ / num_ - mean * mean - sine * sine;
    return {.displayed = {.f_Hz = f_Hz_, .Z = displayed},
            .hand = {.f_Hz = f_Hz_, .Z = displayed + own},
            .sine_N = sine,
            .ripple_N = std::sqrt(std::max(0.0, rest))};
  }

 private:
  double f_Hz_, w_;
  Complex held_;
  Complex X_ = 0, F_ = 0, F_own_ = 0;
  double sum_ = 0, sum_of_squares_ = 0;
  int num_ = 0;
};

/// A simulated rig whose hand moves in each sub-step of the mechanics. It shows the coordinate and the forces
/// of the last period.
class WatchedLink final : public RigLink {
 public:
  WatchedLink(const SceneConfig& scene, const std::shared_ptr<const Hand>& hand, const RigProfiles& profiles)
      : F_hand(static_cast<std::size_t>(to_ns(scene.step) / SimPlant::substep_ns)),
        rig_(sim_rig_config(scene), scene.step, hand, profiles),
        period_ns_(to_ns(scene.step)),
        poll_ns_(gather_time(scene.step) / gather_polls) {}

  std::span<CanBus* const> buses() noexcept override { return rig_.host_buses(); }
  Nanoseconds begin_cycle(double motion_time) noexcept override {
    const Nanoseconds t_before_ns = std::exchange(t_cycle_ns_, t_cycle_ns_ + period_ns_);
    rig_.run_wires(t_cycle_ns_ - 1);
    for (std::size_t i = 0; i < F_hand.size(); ++i) {
      const auto done = static_cast<Nanoseconds>(i + 1),
                 left = static_cast<Nanoseconds>(F_hand.size() - i - 1);
      rig_.run_plant(t_before_ns + done * SimPlant::substep_ns,
                     motion_time - static_cast<double>(left) * substep_s);
      F_hand[i] = rig_.hand_torque(0);
    }
    x = rig_.joints().q[0];
    F = -rig_.applied_torque_Nm(0) / metres_per_rad;
    return t_now_ns_ = t_cycle_ns_;
  }
  Nanoseconds wait(Nanoseconds until) noexcept override {
    t_now_ns_ = std::min(t_now_ns_ + poll_ns_, until);
    rig_.run_wires(t_now_ns_);
    return t_now_ns_;
  }
  void set_observer(const BusObserver& observer) noexcept override { rig_.set_observer(observer); }

  double x = 0, F = 0;         // as in Moment
  std::vector<double> F_hand;  // as in Moment

 private:
  SimRig rig_;
  Nanoseconds period_ns_, poll_ns_, t_cycle_ns_ = 0, t_now_ns_ = 0;
};

[[noreturn]] void fail(const std::vector<std::string>& errors) {
  std::string all;
  for (const std::string& error : errors) all += (all.empty() ? "" : "; ") + error;
  throw std::runtime_error(all);
}

/// Runs the session, and calls use(Moment) after each period from settled_s on.
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
    const double F = -tool.feedback_D.f.x();
    if (watched) use({.t = record.t, .x = watched->x, .F = watched->F, .F_hand = watched->F_hand});
    else use({.t = record.t, .x = tool.target.X_WD.p.x(), .F = F});
  }
}

Felt measure(const FeelCase& c, const Gains& gains, double f_Hz) {
  const double stroke = c.speed / (2 * pi * f_Hz);
  const Sine sine{.offset = c.is_pressed ? pressed_m : 0,
                  .amplitude = c.is_pressed ? std::min(0.005, stroke) : stroke,
                  .f_Hz = f_Hz};
  const double periods = std::ceil(std::max(2.0, f_Hz));  // at least a second
  LockIn lock_in(f_Hz, c.plan.step_s, c.plan.has_buses);
  run_sine(c, gains, sine, periods / f_Hz, [&](const Moment& at) {
    lock_in.add({.t = at.t, .x = at.x - sine.offset, .F = at.F, .F_hand = at.F_hand});
  });
  return lock_in.felt();
}

Impedance by_law(const FeelCase& c, const Gains& gains, double f_Hz) {
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
          {.name = "bus-500Hz", .has_buses = true, .step_s = 2e-3},
          {.name = "bus-1kHz-10um", .has_buses = true, .count_m = 10e-6},
          {.name = "bus-1kHz-100um", .has_buses = true, .count_m = 100e-6}};
}

double Impedance::mass() const {
  const double w = 2 * pi * f_Hz;
  return -Z.real() / (w * w);
}

double Impedance::damping() const { return Z.imag() / (2 * pi * f_Hz); }

std::vector<double> feel_frequencies(int per_decade) {
  std::vector<double> frequencies;
  for (int i = 0; i <= 3 * per_decade; ++i) {
    const double period_s = 0.002 * std::round(std::pow(10, 1 - static_cast<double>(i) / per_decade) / 0.002);
    frequencies.push_back(1 / period_s);
  }
  return frequencies;
}

Felt measure_feel(const FeelCase& c, double f_Hz) { return measure(c, {}, f_Hz); }

Impedance feel_by_law(const FeelCase& c, double f_Hz) { return by_law(c, {}, f_Hz); }

Impedance feel_of_device(double f_Hz) {
  // implicit Euler in each sub-step
  const Complex s = (1.0 - std::polar(1.0, -2 * pi * f_Hz * substep_s)) / substep_s;
  return {.f_Hz = f_Hz, .Z = s * (FeelDevice::mass * s + FeelDevice::damping)};
}

CountBand count_band(const std::vector<Felt>& felt) {
  const auto excess = [&](std::size_t i) { return std::log(felt[i].sine_N / felt[i].ripple_N); };
  const auto f_Hz = [&](std::size_t i) { return felt[i].displayed.f_Hz; };
  // log(sine / ripple) is linear in log f between two measurements
  const auto zero = [&](std::size_t i) {
    const double share = excess(i - 1) / (excess(i - 1) - excess(i));
    return f_Hz(i - 1) * std::pow(f_Hz(i) / f_Hz(i - 1), share);
  };
  CountBand band;
  for (std::size_t i = 0; i < felt.size(); ++i) {
    if (!(excess(i) > 0)) continue;
    if (band.highest == 0) band.lowest = i == 0 ? 0 : zero(i);
    band.highest = i + 1 == felt.size() ? std::numeric_limits<double>::infinity() : zero(i + 1);
  }
  return band;
}

double drag_of(const FeelCase& c) {
  const double f_Hz = 0.1;
  double largest = 0;
  run_sine(c, {}, {.amplitude = 0.2 / (2 * pi * f_Hz), .f_Hz = f_Hz}, 1 / f_Hz,
           [&](const Moment& at) { largest = std::max(largest, std::abs(at.F)); });
  return largest;
}

double delay_of(const FeelPlan& plan) {
  constexpr double f_Hz = 1;
  constexpr Gains spring{.g_d = 0};
  const Impedance felt = measure({.plan = plan, .is_pressed = true}, spring, f_Hz).displayed;
  const Impedance at_once = by_law({.plan = {}, .is_pressed = true}, spring, f_Hz);
  return -std::arg(felt.Z / at_once.Z) / (2 * pi * f_Hz);
}

}  // namespace godobject::study
