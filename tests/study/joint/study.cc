#include "tests/study/joint/study.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/study/compositions.h"
#include "tests/study/csv_writer.h"
#include "tests/study/grid.h"
#include "tests/study/joint/scene.h"
#include "tests/study/reference_solution.h"
#include "tests/support/stabilisation.h"

namespace godobject::study {
namespace {

constexpr double first_stiffness = 1000;  // N/m, that of scene_s3()
constexpr std::size_t map_steps = 1000;

/// Calls f with the scene type and the name of every scheme.
template <class F>
void for_each_scheme(F f) {
  f.template operator()<ToolHeldBy<ImplicitEuler, 4, AtPrediction>>("implicit-euler at-prediction");
  f.template operator()<ToolHeldBy<ImplicitEuler, 4, AtBase>>("implicit-euler at-base");
  f.template operator()<ToolHeldBy<ImplicitEuler, 4, BaumgarteImplicit>>("implicit-euler baumgarte-implicit");
  f.template operator()<ToolHeldBy<ImplicitEuler, 4, BaumgarteDiverging>>(
      "implicit-euler baumgarte-diverging");
  f.template operator()<ToolHeldBy<TrBdf2, 4, AtPrediction>>("tr-bdf2 at-prediction");
}

/// Returns the largest kinetic energy of the bodies at their targets within one second, J.
double device_energy(const oracle::Case& problem) {
  double largest = 0;
  for (int n = 0; n <= 1000; ++n) {
    double E = 0;
    for (const oracle::Body& body : problem.bodies) {
      const oracle::RigidState D = body.coupling->target->at(1e-3 * n);
      const Vec3 w_B = D.q.conjugate() * D.w;
      E += (body.m * D.v.squaredNorm() + w_B.dot(body.I_B * w_B)) / 2;
    }
    largest = std::max(largest, E);
  }
  return largest;
}

/// True for a fault, excessive drift or energy, or values that are not finite.
template <Scene S>
bool has_failed(CaseRun<S>& run, const Drift& drift, double E_device) {
  return any(run.output().fault) || !(drift.m <= max_apart) || !(drift.rad <= max_apart_angle) ||
         !(run.kinetic() <= max_energy_ratio_of_device * E_device);
}

/// Steps until the end or a failure. each(n): called after step n.
template <Scene S, class F>
void run_steps(CaseRun<S>& run, const std::vector<Input<S>>& inputs, double E_device, JointRun& row, F each) {
  for (const Input<S>& in : inputs) {
    run.step(in);
    const Drift drift = run.drift();
    row.failed = has_failed(run, drift, E_device);
    if (row.failed) return;
    row.drift = worst(row.drift, drift);
    each(++row.steps);
  }
}

template <Scene S>
JointRun drift_run(const std::string& scheme, const ReferenceScene& scene, const oracle::Solution& reference,
                   double h) {
  JointRun row{.scheme = scheme, .k = first_stiffness, .h = h, .drift = {}, .errors = {}};
  CaseRun<S> run(scene.problem, h);
  const auto every = static_cast<std::size_t>(std::lround(comparison_step / h));
  run_steps(run, run.inputs(steps_in(scene.duration, h), scene.duration), device_energy(scene.problem), row,
            [&](std::size_t n) {
              if (n % every == 0 && reference.times[n / every] >= scene.from)
                compare(run, reference.states[n / every], row.errors);
            });
  return row;
}

template <Scene S>
void add_map(const std::string& scheme, const JointGrid& grid, std::vector<JointRun>& rows) {
  const oracle::Case soft = scene_s3();
  const double E_device = device_energy(soft);
  for (const double k : grid.stiffnesses) {
    const oracle::Case problem = stiffened(soft, k / first_stiffness);
    for (const double h : grid.steps) {
      JointRun row{.scheme = scheme, .k = k, .h = h, .drift = {}, .errors = {}};
      CaseRun<S> run(problem, h);
      run_steps(run, run.inputs(map_steps, 1e9), E_device, row, [](std::size_t) {});
      rows.push_back(row);
    }
  }
}

double or_nothing(const JointRun& r, double value) {
  return r.failed ? std::numeric_limits<double>::quiet_NaN() : value;
}

}  // namespace

std::vector<std::string> joint_schemes() {
  std::vector<std::string> names;
  for_each_scheme([&]<Scene S>(const std::string& scheme) { names.push_back(scheme); });
  return names;
}

std::vector<JointRun> study_drift(bool quick, const Progress& progress) {
  ReferenceScene scene = reference_s3();
  scene.duration = quick ? 0.6 : 2;
  progress("joints: reference");
  const oracle::Solution reference = reference_of(scene);
  std::vector<JointRun> rows;
  for_each_scheme([&]<Scene S>(const std::string& scheme) {
    progress("joints: drift, " + scheme);
    for (const double h : error_steps(quick))
      if (h >= 0.25e-3) rows.push_back(drift_run<S>(scheme, scene, reference, h));
  });
  return rows;
}

JointGrid joint_grid(bool quick) {
  return {.stiffnesses = log_spaced(1, 1e10, quick ? 6 : 21),
          .steps = log_spaced(1e-4, 1e-2, quick ? 3 : 17)};
}

std::vector<JointRun> study_joint_stability(const JointGrid& grid, const Progress& progress) {
  std::vector<JointRun> rows;
  for_each_scheme([&]<Scene S>(const std::string& scheme) {
    progress("joints: stability, " + scheme);
    add_map<S>(scheme, grid, rows);
  });
  return rows;
}

void write_drift_csv(const std::filesystem::path& file, const std::vector<JointRun>& rows) {
  CsvWriter csv(file, "scheme,step_s,failed,steps,drift_m,drift_rad,position_error_m,rotation_error_rad");
  for (const JointRun& r : rows)
    csv.row(r.scheme, r.h, r.failed ? 1 : 0, r.steps, or_nothing(r, r.drift.m), or_nothing(r, r.drift.rad),
            or_nothing(r, r.errors.position), or_nothing(r, r.errors.rotation));
}

void write_joint_stability_csv(const std::filesystem::path& file, const std::vector<JointRun>& rows) {
  CsvWriter csv(file, "scheme,stiffness_N_m,step_s,failed,steps,drift_m,drift_rad");
  for (const JointRun& r : rows)
    csv.row(r.scheme, r.k, r.h, r.failed ? 1 : 0, r.steps, or_nothing(r, r.drift.m),
            or_nothing(r, r.drift.rad));
}

}  // namespace godobject::study
