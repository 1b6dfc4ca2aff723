#include "sim/study/error_study.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "sim/study/case_run.h"
#include "sim/study/compositions.h"
#include "sim/study/csv_writer.h"
#include "tests/oracle/solve.h"

namespace godobject::study {
namespace {

constexpr double comparison_step = 4e-3;    // s
constexpr double resolvable_error = 1e-11;  // m, rad: below it an order is an order of rounding

std::size_t steps_in(double duration, double h) {
  return static_cast<std::size_t>(std::lround(duration / h));
}

oracle::Solution reference_of(const ReferenceScene& scene) {
  const std::vector<double> times = oracle::uniform_times(scene.duration, comparison_step);
  return oracle::solve(scene.problem, times);
}

double angle_between(const Quat& a, const Quat& b) {
  const Quat difference = a.conjugate() * b;
  return 2 * std::atan2(difference.vec().norm(), std::abs(difference.w()));
}

Vec3 angular_momentum(const RigidBodyParams& par, const RigidBodyState& x) {
  return to_world(x.X_WB.q, par.I_B * x.w_B);
}

/// Runs the scene once and sets it against the reference.
template <Scene S>
Errors compare(const ReferenceScene& scene, const oracle::Solution& reference, CaseRun<S>& run, double h) {
  const RigidBodyParams& body = run.params().bodies[0].body;
  const double E_0 = run.kinetic();
  const Vec3 L_0 = angular_momentum(body, run.body());
  const auto every = static_cast<std::size_t>(std::lround(comparison_step / h));
  const std::vector<Input<S>> inputs = run.inputs(steps_in(scene.duration, h), scene.duration);

  Errors worst;
  if constexpr (!uses<typename S::Coupling>) worst.energy = worst.momentum = 0;
  for (std::size_t n = 1; n <= inputs.size(); ++n) {
    run.step(inputs[n - 1]);
    if (any(run.output().fault)) throw std::runtime_error(scene.name + ": the step reported a fault");
    if (n % every != 0 || n / every >= reference.times.size() || reference.times[n / every] < scene.from)
      continue;
    const RigidBodyState& x = run.body();
    const oracle::RigidState& exact = reference.states[n / every][0];
    worst.position = std::max(worst.position, (x.X_WB.p - exact.p).norm());
    worst.rotation = std::max(worst.rotation, angle_between(x.X_WB.q, Quat(exact.q)));
    if constexpr (!uses<typename S::Coupling>) {
      worst.energy = std::max(*worst.energy, std::abs(run.kinetic() / E_0 - 1));
      worst.momentum = std::max(*worst.momentum, (angular_momentum(body, x) - L_0).norm() / L_0.norm());
    }
  }
  return worst;
}

/// Median time of one step, ns, over stretches of up to 1000 steps: long enough for the clock, short
/// enough that most are not interrupted. The inputs are there before the clock starts.
template <Scene S>
double time_step(const ReferenceScene& scene, CaseRun<S>& run, double h, std::size_t min_steps) {
  using Clock = std::chrono::steady_clock;
  constexpr std::size_t stretch = 1000;
  const std::vector<Input<S>> inputs = run.inputs(steps_in(scene.duration, h), scene.duration);
  std::vector<double> times;
  for (std::size_t done = 0; done < min_steps; done += inputs.size()) {
    run.restart();
    for (std::size_t n = 0; n < inputs.size();) {
      const std::size_t first = n, end = std::min(inputs.size(), n + stretch);
      const Clock::time_point start = Clock::now();
      for (; n < end; ++n) run.step(inputs[n]);
      const std::chrono::duration<double, std::nano> elapsed = Clock::now() - start;
      times.push_back(elapsed.count() / static_cast<double>(end - first));
    }
  }
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  return *middle;
}

std::optional<double> order(double coarse, double fine) {
  if (!(fine > resolvable_error)) return std::nullopt;
  return std::log2(coarse / fine);
}

/// One composition on one scene at every step.
template <Scene S>
void add_rows(const ReferenceScene& scene, const oracle::Solution& reference, bool quick,
              std::optional<double> instructions, const Progress& progress, std::vector<ErrorRow>& rows) {
  const ErrorRow* coarser = nullptr;
  const std::vector<double> steps = error_steps(quick);
  rows.reserve(rows.size() + steps.size());
  for (const double h : steps) {
    progress("error: " + scene.name + ", " + S::Integrator::name + ", " +
             std::to_string(std::lround(h * 1e6)) + " us");
    CaseRun<S> run(scene.problem, h);
    ErrorRow row;
    row.scene = scene.name;
    row.integrator = S::Integrator::name;
    row.h = h;
    row.errors = compare(scene, reference, run, h);
    row.ns_per_step = time_step(scene, run, h, quick ? 20'000 : 200'000);
    row.instructions_per_step = instructions;
    if (coarser != nullptr) {
      row.order_position = order(coarser->errors.position, row.errors.position);
      row.order_rotation = order(coarser->errors.rotation, row.errors.rotation);
    }
    rows.push_back(row);
    coarser = &rows.back();
  }
}

bool is_coupled(const ReferenceScene& scene) { return scene.problem.bodies.front().coupling.has_value(); }

template <class Integrator>
void add_integrator(const ReferenceScene& scene, const oracle::Solution& reference, bool quick,
                    InstructionCounter& counter, const Progress& progress, std::vector<ErrorRow>& rows) {
  const std::string name = Integrator::name;
  if (is_coupled(scene))
    add_rows<Follower<Integrator, 1>>(scene, reference, quick, counter.per_step("pose-1 " + name), progress,
                                      rows);
  else
    add_rows<Free<Integrator, 1>>(scene, reference, quick, counter.per_step("free-1 " + name), progress,
                                  rows);
}

template <class Integrator>
Errors errors_of(const ReferenceScene& scene, double h) {
  const oracle::Solution reference = reference_of(scene);
  if (is_coupled(scene)) {
    CaseRun<Follower<Integrator, 1>> run(scene.problem, h);
    return compare(scene, reference, run, h);
  }
  CaseRun<Free<Integrator, 1>> run(scene.problem, h);
  return compare(scene, reference, run, h);
}

}  // namespace

std::optional<double> ErrorRow::instructions_per_second() const {
  if (!instructions_per_step) return std::nullopt;
  return *instructions_per_step / h;
}

std::vector<double> error_steps(bool quick) {
  if (quick) return {4e-3, 2e-3, 1e-3};
  return {4e-3, 2e-3, 1e-3, 0.5e-3, 0.25e-3, 0.125e-3};
}

std::vector<ErrorRow> study_error(const std::vector<ReferenceScene>& scenes, bool quick,
                                  InstructionCounter& counter, const Progress& progress) {
  std::vector<ErrorRow> rows;
  for (ReferenceScene scene : scenes) {
    if (quick) scene.duration = std::min(scene.duration, 2.0);
    progress("error: " + scene.name + ", oracle");
    const oracle::Solution reference = reference_of(scene);
    add_integrator<ImplicitEuler>(scene, reference, quick, counter, progress, rows);
    add_integrator<TrBdf2>(scene, reference, quick, counter, progress, rows);
  }
  return rows;
}

Errors measure_errors(const ReferenceScene& scene, const std::string& integrator, double h) {
  return integrator == ImplicitEuler::name ? errors_of<ImplicitEuler>(scene, h) : errors_of<TrBdf2>(scene, h);
}

void write_csv(const std::filesystem::path& file, const std::vector<ErrorRow>& rows) {
  CsvWriter csv(file,
                "scene,integrator,step_s,position_error_m,rotation_error_rad,energy_error,momentum_error,"
                "position_order,rotation_order,ns_per_step,ns_per_simulated_s,instructions_per_step,"
                "instructions_per_simulated_s");
  for (const ErrorRow& r : rows)
    csv.row(r.scene, r.integrator, r.h, r.errors.position, r.errors.rotation, r.errors.energy,
            r.errors.momentum, r.order_position, r.order_rotation, r.ns_per_step, r.ns_per_second(),
            r.instructions_per_step, r.instructions_per_second());
}

}  // namespace godobject::study
