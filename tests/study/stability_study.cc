#include "tests/study/stability_study.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

#include "core/godobject.h"
#include "tests/study/compositions.h"
#include "tests/study/csv_writer.h"
#include "tests/study/explicit_coupling.h"
#include "tests/study/grid.h"

namespace godobject::study {
namespace {

constexpr double mass = 0.1;  // kg
constexpr double arm = 0.1;   // m: radius of gyration, initial displacement
constexpr std::size_t min_steps = 1000;

struct Oscillator {
  RigidBodyParams body;
  SpringParams spring;
  RigidBodyState start;
};

Oscillator oscillator_of(const StabilityCell& c) {
  const double I = mass * arm * arm, k_r = c.k * arm * arm;
  Oscillator o;
  o.body = rigid_body(mass, Vec3(I, I, I / c.inertia_ratio).asDiagonal());
  o.spring = {
      .k = c.k, .g = c.damping * std::sqrt(mass * c.k), .k_r = k_r, .g_r = c.damping * std::sqrt(I * k_r)};
  o.start.X_WB = {.p = arm * Vec3(2, -1, 2) / 3, .q = exp_so3(Vec3(1, 2, 2) / 3)};
  return o;
}

struct Energy {
  double translation = 0, rotation = 0;  // J, kinetic and spring

  double total() const { return translation + rotation; }
};

/// Returns the energy. The target rests at the origin.
Energy energy_of(const Oscillator& o, const RigidBodyState& x) {
  const double n = x.X_WB.q.vec().norm();
  const double alpha = 2 * std::atan2(n, std::abs(x.X_WB.q.w()));
  return {.translation = (mass * x.v_W.squaredNorm() + o.spring.k * x.X_WB.p.squaredNorm()) / 2,
          .rotation = (x.w_B.dot(o.body.I_B * x.w_B) + o.spring.k_r * alpha * alpha) / 2};
}

/// A body stepped by the core.
template <class Integrator>
class ImplicitBody {
 public:
  ImplicitBody(const Oscillator& o, double h) {
    par_.h = h;
    par_.bodies[0].body = o.body;
    par_.bodies[0].coupling = o.spring;
    par_.bodies[0].device.rise = 0;
    place(x_, 0, {.X_WB = o.start.X_WB, .V_WB = {}});
    engage_at(x_, 0, Target{});
  }

  /// Returns false for a fault.
  bool step() {
    godobject::step(par_, in_, x_, w_, out_);
    return !any(out_.fault);
  }
  const RigidBodyState& state() const { return x_.bodies[0].x; }

 private:
  using S = Follower<Integrator, 1>;
  Params<S> par_;
  Input<S> in_;
  State<S> x_;
  Scratch<S> w_;
  Output<S> out_;
};

class ExplicitBody {
 public:
  ExplicitBody(const Oscillator& o, double h) : coupling_(o.body, o.spring, Pose{}), h_(h), x_(o.start) {}

  bool step() {
    coupling_.step(h_, x_);
    return true;
  }
  const RigidBodyState& state() const { return x_; }

 private:
  ExplicitCoupling coupling_;
  double h_;
  RigidBodyState x_;
};

/// Returns the share of the initial energy that the exact oscillation, released from rest, has at time t:
/// x = e^(-z w t) (cos w_d t + z w S),  v = -e^(-z w t) w^2 S,  S = sin(w_d t) / w_d,  0 <= z <= 1.
double exact_energy_share(double w, double z, double t) {
  const double w_d = w * std::sqrt(1 - z * z);
  const double S = w_d * t > 1e-8 ? std::sin(w_d * t) / w_d : t;
  const double decay = std::exp(-z * w * t);
  const double x = decay * (std::cos(w_d * t) + z * w * S), v_over_w = decay * w * S;
  return x * x + v_over_w * v_over_w;
}

template <class Body>
StabilityResult run(const std::string& scheme, const StabilityCell& cell) {
  const Oscillator o = oscillator_of(cell);
  const double w = std::sqrt(cell.k / mass), period = 2 * std::numbers::pi / w;
  const std::size_t steps = std::max(min_steps, static_cast<std::size_t>(std::ceil(period / cell.h)));
  Body body(o, cell.h);
  const Energy first = energy_of(o, body.state());
  double least = first.total();
  StabilityResult result;
  result.scheme = scheme;
  result.cell = cell;
  for (std::size_t n = 1; n <= steps; ++n) {
    const bool ok = body.step();
    const Energy E = energy_of(o, body.state());
    if (!ok || !(E.total() <= max_energy_ratio * first.total())) {
      result.rise = result.loss = std::numeric_limits<double>::quiet_NaN();
      return result;  // failed
    }
    least = std::min(least, E.total());
    result.rise = std::max(result.rise, (E.total() - least) / first.total());
    const double t = static_cast<double>(n) * cell.h;
    if (n == 1 || t <= period) {
      const double exact = exact_energy_share(w, cell.damping / 2, t);
      result.loss = std::max(result.loss, exact - E.translation / first.translation);
    }
  }
  result.stability = result.rise > max_energy_rise   ? Stability::energy_gaining
                     : result.loss > max_energy_loss ? Stability::dissipative
                                                     : Stability::stable;
  return result;
}

}  // namespace

double StabilityCell::wh() const { return h * std::sqrt(k / mass); }

StabilityGrid stability_grid(bool quick) {
  return {.stiffnesses = log_spaced(1, 1e12, quick ? 13 : 37),
          .steps = log_spaced(quick ? 1e-4 : 1e-5, 5e-2, quick ? 6 : 25),
          .dampings = {0, 0.2, 1.4, 2},
          .inertia_ratios = {1, 1e3, 1e6}};
}

StabilityResult classify(const std::string& scheme, const StabilityCell& cell) {
  if (scheme == explicit_name) return run<ExplicitBody>(scheme, cell);
  if (scheme == ImplicitEuler::name) return run<ImplicitBody<ImplicitEuler>>(scheme, cell);
  return run<ImplicitBody<TrBdf2>>(scheme, cell);
}

std::vector<StabilityResult> study_stability(const StabilityGrid& grid, const Progress& progress) {
  std::vector<StabilityResult> results;
  for (const std::string scheme : stability_schemes)
    for (const double damping : grid.dampings)
      for (const double inertia_ratio : grid.inertia_ratios) {
        std::ostringstream panel;
        panel << "stability: " << scheme << ", damping ratio " << damping << ", inertia ratio "
              << inertia_ratio;
        progress(panel.str());
        for (const double k : grid.stiffnesses)
          for (const double h : grid.steps)
            results.push_back(
                classify(scheme, {.k = k, .h = h, .damping = damping, .inertia_ratio = inertia_ratio}));
      }
  return results;
}

double explicit_limit(double damping, double inertia_ratio) {
  const double faster = std::sqrt(inertia_ratio), z = damping / 2 * faster;
  return 2 * (std::sqrt(z * z + 1) - z) / faster;
}

double measured_explicit_limit(double damping) {
  double low = 0.1, high = 4;  // bounds of h sqrt(k / m): stable, unstable
  while (high - low > 1e-4) {
    const double wh = (low + high) / 2, k = 1000;
    Oscillator o = oscillator_of({.k = k, .h = 0, .damping = damping, .inertia_ratio = 1});
    o.start.X_WB.q.setIdentity();
    ExplicitBody body(o, wh * std::sqrt(mass / k));
    for (int n = 0; n < 100000; ++n) body.step();
    // bounded: without damping the energy only oscillates (by less than 1e6 short of the limit)
    const bool bounded =
        energy_of(o, body.state()).translation <= max_energy_ratio * energy_of(o, o.start).translation;
    (bounded ? low : high) = wh;
  }
  return (low + high) / 2;
}

void write_csv(const std::filesystem::path& file, const std::vector<StabilityResult>& results) {
  CsvWriter csv(file,
                "scheme,stiffness_N_m,step_s,damping_ratio,inertia_ratio,wh,class,class_number,energy_rise,"
                "energy_loss_beyond_exact");
  for (const StabilityResult& r : results)
    csv.row(r.scheme, r.cell.k, r.cell.h, r.cell.damping, r.cell.inertia_ratio, r.cell.wh(),
            stability_names[static_cast<std::size_t>(r.stability)], static_cast<int>(r.stability), r.rise,
            r.loss);
}

}  // namespace godobject::study
