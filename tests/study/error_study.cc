#include "tests/study/error_study.h"

#include <algorithm>
#include <cmath>

#include "tests/study/compositions.h"
#include "tests/study/csv_writer.h"
#include "tests/study/reference_solution.h"
#include "tests/study/step_time.h"

namespace godobject::study {
namespace {

constexpr double resolvable_error = 1e-11;  // m, rad: below it the order is that of rounding errors

std::optional<double> order(double coarse, double fine) {
  if (!(fine > resolvable_error)) return std::nullopt;
  return std::log2(coarse / fine);
}

/// Adds rows of one composition on one scene at every step.
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
    row.ns_per_step =
        time_step(run, run.inputs(steps_in(scene.duration, h), scene.duration), quick ? 20'000 : 200'000);
    row.instructions_per_step = instructions;
    if (coarser != nullptr) {
      row.order_position = order(coarser->errors.position, row.errors.position);
      row.order_rotation = order(coarser->errors.rotation, row.errors.rotation);
    }
    rows.push_back(row);
    coarser = &rows.back();
  }
}

/// Calls f with the smallest composition that holds the scene, and its name for the probe.
template <class Integrator, class F>
auto with_composition(const ReferenceScene& scene, F&& f) {
  const std::string name = Integrator::name;
  if (!scene.is_articulated())
    return scene.is_coupled() ? f.template operator()<Follower<Integrator, 1>>("pose-1 " + name, "s1")
                              : f.template operator()<Free<Integrator, 1>>("free-1 " + name, "s1");
  return scene.is_coupled() ? f.template operator()<Tool<Integrator, 4>>("pose-joints-4 " + name, "s3")
                            : f.template operator()<FreeJoints<Integrator, 8>>("free-joints-8 " + name, "s5");
}

template <class Integrator>
void add_integrator(const ReferenceScene& scene, const oracle::Solution& reference, bool quick,
                    InstructionCounter& counter, const Progress& progress, std::vector<ErrorRow>& rows) {
  with_composition<Integrator>(scene, [&]<Scene S>(const std::string& composition, const char* motion) {
    add_rows<S>(scene, reference, quick, counter.per_step(composition, motion), progress, rows);
  });
}

template <class Integrator>
Errors errors_of(const ReferenceScene& scene, double h) {
  return with_composition<Integrator>(scene, [&]<Scene S>(const std::string&, const char*) {
    CaseRun<S> run(scene.problem, h);
    return compare(scene, reference_of(scene), run, h);
  });
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
    if (quick) scene.duration = std::min(scene.duration, scene.stiff ? 0.6 : 2.0);
    progress("error: " + scene.name + ", reference");
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
  CsvWriter csv(
      file,
      "scene,integrator,step_s,position_error_m,rotation_error_rad,energy_error,momentum_error,"
      "position_order,rotation_order,drift_m,drift_rad,ns_per_step,ns_per_simulated_s,instructions_per_step,"
      "instructions_per_simulated_s");
  for (const ErrorRow& r : rows) {
    const std::optional<Drift>& drift = r.errors.drift;
    csv.row(r.scene, r.integrator, r.h, r.errors.position, r.errors.rotation, r.errors.energy,
            r.errors.momentum, r.order_position, r.order_rotation,
            drift ? std::optional(drift->m) : std::nullopt, drift ? std::optional(drift->rad) : std::nullopt,
            r.ns_per_step, r.ns_per_second(), r.instructions_per_step, r.instructions_per_second());
  }
}

}  // namespace godobject::study
