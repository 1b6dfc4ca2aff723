#include "tests/study/contact/stability.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "tests/oracle/target.h"
#include "tests/study/contact/run.h"
#include "tests/study/csv_writer.h"
#include "tests/study/grid.h"

namespace godobject::study {
namespace {

constexpr double longest_run = 0.6;  // s
constexpr std::size_t most_steps = 2000;
constexpr double drag_begins = 0.3;  // s

/// Returns the target: 1 cm in the plane, at rest first, then to and fro.
oracle::RigidState dragged(double t) {
  const double u = std::max(t - drag_begins, 0.0);
  oracle::RigidState D;
  D.p = Vec3(0.05 * (1 - std::cos(10 * u)), 0.03 * (1 - std::cos(14 * u)), -0.01);
  D.v = Vec3(0.5 * std::sin(10 * u), 0.42 * std::sin(14 * u), 0);
  D.q = Quat(Eigen::AngleAxisd(1.5, Vec3(0.6, 0.8, 0)));
  return D;
}

bench::ContactScene rod(const ContactCell& cell) {
  bench::ContactScene scene;
  scene.problem.gravity = Vec3(0, 0, -9.81);
  oracle::Body& body = scene.problem.bodies.emplace_back();
  body.m = 0.1;
  body.I_B = Vec3(3.4667e-4, 3.4667e-4, 2.6667e-5).asDiagonal();
  body.start.p = Vec3(0, 0, 0.08);
  body.start.q = Quat(Eigen::AngleAxisd(1.2, Vec3(0.6, 0.8, 0)));
  for (int i = 0; i < 5; ++i) scene.centres.emplace_back(0, 0, -0.08 + 0.04 * i);
  scene.radius = 0.02;
  const double c = 2 * cell.damping * std::sqrt(body.m * cell.k);
  scene.law = {.k = cell.k, .c = c, .mu = 0.5, .k_t = cell.k, .c_t = c};
  return scene;
}

bench::ContactScene thrown_rod(const ContactCell& cell) {
  bench::ContactScene scene = rod(cell);
  oracle::RigidState& start = scene.problem.bodies.front().start;
  start.v = Vec3(1, 0, -1);
  start.w = start.q * Vec3(3, 5, 20);
  return scene;
}

bench::ContactScene dragged_rod(const ContactCell& cell) {
  bench::ContactScene scene = rod(cell);
  oracle::Body& body = scene.problem.bodies.front();
  body.coupling = {.k_t = 1000,
                   .g_t = 1.4 * std::sqrt(body.m * 1000),
                   .k_r = 1,
                   .g_r = 1.4 * std::sqrt(body.I_B(0, 0)),
                   .target = std::make_shared<oracle::FunctionTarget>(dragged)};
  return scene;
}

template <class I>
struct Rod : Follower<I, 1> {
  using Contacts = FixedContacts<5, 1, 5>;
};

/// Returns the energy gain, J; infinite if the run failed.
template <Scene S>
double gain_of(const bench::ContactScene& scene, double h) {
  CaseRun<S> run(scene.problem, h);
  set_contacts(scene, run.params());
  const double first = energy(run.params(), run.state());
  double work = 0, gain = 0;
  const std::size_t steps = std::min(most_steps, static_cast<std::size_t>(longest_run / h));
  Vec3 p_before = dragged(0).p;
  for (const Input<S>& in : run.inputs(steps, longest_run)) {
    run.step(in);
    const double E = energy(run.params(), run.state());
    if (any(run.output().fault) || !std::isfinite(E)) return std::numeric_limits<double>::infinity();
    const Vec3& p_now = in.devices[0].target.X_WD.p;
    work += coupling_at(run.params(), run.state(), 0).F_WB.f.dot(p_now - p_before);
    p_before = p_now;
    gain = std::max(gain, E - first - work);
  }
  return gain;
}

template <class I>
double gain_with(const ContactCell& cell) {
  return std::max(gain_of<Rod<I>>(thrown_rod(cell), cell.h), gain_of<Rod<I>>(dragged_rod(cell), cell.h));
}

}  // namespace

ContactGrid contact_grid(bool quick) {
  return {.dampings = {0, 0.1, 1, 10, 100},
          .stiffnesses = log_spaced(1e2, 1e9, quick ? 4 : 15),
          .steps = log_spaced(1e-4, 5e-3, quick ? 2 : 9)};
}

ContactStability contact_gain(const std::string& integrator, const ContactCell& cell) {
  const double gain =
      integrator == ImplicitEuler::name ? gain_with<ImplicitEuler>(cell) : gain_with<TrBdf2>(cell);
  return {.integrator = integrator, .cell = cell, .failed = !std::isfinite(gain), .gain = gain};
}

std::vector<ContactStability> study_contact_stability(const ContactGrid& grid, const Progress& progress) {
  std::vector<ContactStability> rows;
  for (const std::string integrator : {ImplicitEuler::name, TrBdf2::name})
    for (const double damping : grid.dampings) {
      progress("contacts: stability, " + integrator + ", damping ratio " + std::to_string(damping));
      for (const double k : grid.stiffnesses)
        for (const double h : grid.steps) rows.push_back(contact_gain(integrator, {k, damping, h}));
    }
  return rows;
}

void write_csv(const std::filesystem::path& file, const std::vector<ContactStability>& rows) {
  CsvWriter csv(file, "integrator,stiffness_N_m,damping_ratio,step_s,failed,gain_J");
  for (const ContactStability& r : rows)
    csv.row(r.integrator, r.cell.k, r.cell.damping, r.cell.h, r.failed ? 1 : 0, r.gain);
}

}  // namespace godobject::study
