#include "tests/study/contact/error.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tests/study/contact/run.h"
#include "tests/study/csv_writer.h"
#include "tests/study/step_time.h"

namespace godobject::study {
namespace {

constexpr double longest_step = 2e-3;  // s: a multiple of every step

std::vector<double> contact_steps(const bench::ContactScene& scene, bool quick) {
  const bool is_coupled = scene.problem.bodies.front().coupling.has_value();
  // a bounce is short: its order appears only at small steps
  const int halvings = quick ? 3 : is_coupled ? 4 : 6;
  std::vector<double> steps;
  for (int i = 0; i <= halvings; ++i) steps.push_back(std::ldexp(longest_step, -i));
  return steps;
}

/// Returns the body at the start and after every step.
template <Scene S>
oracle::Solution solve_by_steps(const bench::ContactScene& scene, CaseRun<S>& run,
                                const std::vector<Input<S>>& inputs, double h) {
  oracle::Solution own{.times = {0}, .states = {{oracle_state(run.body(0))}}};
  for (std::size_t n = 1; n <= inputs.size(); ++n) {
    run.step(inputs[n - 1]);
    if (any(run.output().fault)) throw std::runtime_error(scene.name + ": the step reported a fault");
    own.times.push_back(static_cast<double>(n) * h);
    own.states.push_back({oracle_state(run.body(0))});
  }
  return own;
}

void compare(const ContactCase& c, const oracle::Solution& own, ContactErrorRow& row) {
  for (std::size_t i = 0; i < c.exact.times.size(); ++i) {
    const double t = c.exact.times[i];
    if (std::abs(std::remainder(t, longest_step)) > 1e-9) continue;
    const auto n = static_cast<std::size_t>(std::lround(t / row.h));
    if (n >= own.times.size()) continue;
    const oracle::RigidState &x = own.states[n].front(), &exact = c.exact.states[i].front();
    row.position = std::max(row.position, (x.p - exact.p).norm());
    row.penetration =
        std::max(row.penetration, std::abs(penetration(c.scene, x) - penetration(c.scene, exact)));
    row.energy = std::max(row.energy,
                          std::abs(mechanical_energy(c.scene, x, t) - mechanical_energy(c.scene, exact, t)));
  }
}

/// Returns the largest rise of the energy above its lowest value so far, J.
double largest_rise(const bench::ContactScene& scene, const oracle::Solution& own) {
  double lowest = mechanical_energy(scene, own.states.front().front(), 0), rise = 0;
  for (std::size_t n = 1; n < own.times.size(); ++n) {
    const double E = mechanical_energy(scene, own.states[n].front(), own.times[n]);
    rise = std::max(rise, E - lowest);
    lowest = std::min(lowest, E);
  }
  return rise;
}

template <Scene S>
ContactErrorRow measure(const ContactCase& c, double h, bool quick) {
  ContactErrorRow row{.scene = c.scene.name, .integrator = S::Integrator::name, .h = h};
  CaseRun<S> run(c.scene.problem, h);
  set_contacts(c.scene, run.params());
  const std::vector<Input<S>> inputs = run.inputs(steps_in(c.scene.duration, h), c.scene.duration);
  const oracle::Solution own = solve_by_steps(c.scene, run, inputs, h);
  compare(c, own, row);
  if (!c.scene.problem.bodies.front().coupling) {
    const std::vector<Flight> found = flights(c.scene, own);
    row.rise = largest_rise(c.scene, own);
    row.restitution = restitution(found);
    row.restitution_error = std::abs(*row.restitution - restitution(flights(c.scene, c.exact)));
    row.flight_error = worst_flight_error(found, flights(c.scene, c.exact));
  }
  row.ns_per_step = time_step(run, inputs, quick ? 10'000 : 100'000);
  return row;
}

/// Returns the order: log2 of the error at twice the step over the error.
std::optional<double> order_of(double coarser, double error) {
  if (!(coarser > 0 && error > 0)) return std::nullopt;
  return std::log2(coarser / error);
}

template <Scene S>
void add_rows(const ContactCase& c, bool quick, const Progress& progress,
              std::vector<ContactErrorRow>& rows) {
  progress("contacts: " + c.scene.name + ", " + S::Integrator::name);
  std::optional<ContactErrorRow> coarser;
  for (const double h : contact_steps(c.scene, quick)) {
    ContactErrorRow row = measure<S>(c, h, quick);
    if (coarser) row.order = order_of(coarser->position, row.position);
    if (coarser && row.restitution_error)
      row.restitution_order = order_of(*coarser->restitution_error, *row.restitution_error);
    rows.push_back(row);
    coarser = row;
  }
}

template <class I>
void add_integrator(const ContactCase& c, bool quick, const Progress& progress,
                    std::vector<ContactErrorRow>& rows) {
  if (c.scene.problem.bodies.front().coupling) add_rows<PressedTool<I, 1>>(c, quick, progress, rows);
  else add_rows<Ball<I, 1>>(c, quick, progress, rows);
}

}  // namespace

ContactErrors study_contact_errors(const std::vector<ContactCase>& cases, bool quick,
                                   const Progress& progress) {
  ContactErrors errors;
  for (const ContactCase& c : cases) {
    add_integrator<ImplicitEuler>(c, quick, progress, errors.rows);
    add_integrator<TrBdf2>(c, quick, progress, errors.rows);
    if (!c.scene.problem.bodies.front().coupling)
      errors.restitution_reference = restitution(flights(c.scene, c.exact));
  }
  return errors;
}

const ContactErrorRow* find(const std::vector<ContactErrorRow>& rows, const std::string& scene,
                            const std::string& integrator, double h) {
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const ContactErrorRow& r) {
    return r.scene == scene && r.integrator == integrator && std::abs(r.h / h - 1) < 1e-6;
  });
  return row == rows.end() ? nullptr : &*row;
}

void write_csv(const std::filesystem::path& file, const std::vector<ContactErrorRow>& rows) {
  CsvWriter csv(file,
                "scene,integrator,step_s,position_error_m,position_order,penetration_error_m,energy_error_J,"
                "energy_rise_J,restitution,restitution_order,flight_error,ns_per_step,ns_per_simulated_s");
  for (const ContactErrorRow& r : rows)
    csv.row(r.scene, r.integrator, r.h, r.position, r.order, r.penetration, r.energy, r.rise, r.restitution,
            r.restitution_order, r.flight_error, r.ns_per_step, r.ns_per_second());
}

}  // namespace godobject::study
