#include "tests/study/contact/imposed.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "platform/scene/toml.h"
#include "platform/session/session.h"
#include "tests/study/csv_writer.h"

namespace godobject::study {
namespace {

constexpr double sample_step = 0.01;  // s
constexpr double quick_duration = 2;  // s

[[noreturn]] void refuse(const std::vector<std::string>& errors) {
  throw std::runtime_error(errors.empty() ? "the scene cannot be run" : errors.front());
}

/// Evaluates the bricks of a running scene.
class Pile {
 public:
  Pile(const SceneConfig& scene, const CycleRecord& start) : scene_(scene), ejected_(scene.bodies.size()) {
    first_energy_ = energy(start);
  }

  std::size_t num_bricks() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(scene_.bodies, [](const BodyConfig& b) { return !b.coupling; }));
  }

  void add(const CycleRecord& record, PileSample& peak) {
    peak.t = record.t;
    peak.overlap = std::max(peak.overlap, record.contacts.deepest);
    peak.residual = std::max(peak.residual, record.contacts.residual);
    if (record.held) peak.force = std::max(peak.force, record.bodies[*record.held].contact_W.f.norm());
    peak.energy = std::max(peak.energy, energy(record) - first_energy_);
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i)
      if (!scene_.bodies[i].coupling && is_ejected(record.bodies[i])) ejected_[i] = true;
    peak.ejected = static_cast<std::size_t>(std::ranges::count(ejected_, true));
  }

 private:
  static bool is_ejected(const BodyView& body) {
    const Vec3& p = body.X_WB.p;
    const bool on_board =
        std::abs(p.x()) <= board_half_x && std::abs(p.y()) <= board_half_y && p.z() >= -board_depth;
    return !on_board || !(body.V_WB.v.norm() <= ejected_speed);
  }

  /// Returns the kinetic and potential energy of the bricks that are never held, J.
  double energy(const CycleRecord& record) const {
    double E = 0;
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const BodyConfig& body = scene_.bodies[i];
      if (body.coupling) continue;
      const BodyView& now = record.bodies[i];
      const Vec3 w_B = now.X_WB.q.conjugate() * now.V_WB.w;
      E += body.mass * (now.V_WB.v.squaredNorm() / 2 - scene_.gravity.dot(now.X_WB.p)) +
           w_B.dot(body.inertia * w_B) / 2;
    }
    return E;
  }

  const SceneConfig& scene_;
  std::vector<bool> ejected_;
  double first_energy_ = 0;
};

PileSample largest(const PileSample& a, const PileSample& b) {
  return {.t = b.t,
          .overlap = std::max(a.overlap, b.overlap),
          .force = std::max(a.force, b.force),
          .energy = std::max(a.energy, b.energy),
          .residual = std::max(a.residual, b.residual),
          .ejected = std::max(a.ejected, b.ejected)};
}

godobject::Motion motion_of(const SceneConfig& scene, const std::string& file) {
  if (file.empty()) return godobject::Motion(scene);
  MotionResult read = godobject::Motion::read(file, scene);
  if (!read.motion) refuse(read.errors);
  return *std::move(read.motion);
}

}  // namespace

std::array<CouplingMode, 2> both_couplings() { return {CouplingMode::god_object, CouplingMode::imposed}; }

std::string plunge_motion() { return GODOBJECT_STUDY_SCENE_DIRECTORY "/plunge.csv"; }

PileRun run_pile(SceneConfig scene, CouplingMode coupling, const std::string& motion, double duration) {
  scene.coupling = coupling;
  Session::Made made = Session::make(scene, motion_of(scene, motion));
  if (!made.session) refuse(made.errors);
  CycleRecord record = made.session->at_start();
  Pile pile(scene, record);
  PileRun run{.coupling = coupling_names[static_cast<std::size_t>(coupling)],
              .samples = {},
              .worst = {},
              .bricks = pile.num_bricks()};
  const std::size_t every = static_cast<std::size_t>(std::lround(sample_step / scene.step));
  PileSample peak;
  for (std::size_t n = 1; n <= static_cast<std::size_t>(std::lround(duration / scene.step)); ++n) {
    made.session->cycle(record);
    run.num_faults += any(record.fault) ? 1 : 0;
    pile.add(record, peak);
    if (n % every != 0) continue;
    run.samples.push_back(peak);
    run.worst = largest(run.worst, peak);
    peak = {};
  }
  return run;
}

std::vector<PileRun> study_imposed(const std::filesystem::path& scenes, bool quick,
                                   const Progress& progress) {
  LoadResult loaded = load_scene((scenes / "lego.toml").string());
  if (!loaded.scene) refuse(loaded.errors);
  const std::string motion = quick ? "" : (scenes / "lego-motion.csv").string();
  const double duration = quick ? quick_duration : loaded.scene->duration;
  std::vector<PileRun> runs;
  for (const CouplingMode coupling : both_couplings()) {
    progress(std::string("contacts: lego, ") + coupling_names[static_cast<std::size_t>(coupling)]);
    runs.push_back(run_pile(*loaded.scene, coupling, motion, duration));
  }
  for (const CouplingMode coupling : both_couplings()) {
    runs.push_back(run_pile(*loaded.scene, coupling, plunge_motion(), plunge_duration));
    runs.back().coupling = coupling == CouplingMode::god_object ? "god-object plunging" : "placed plunging";
  }
  return runs;
}

void write_csv(const std::filesystem::path& file, const std::vector<PileRun>& runs) {
  CsvWriter csv(file, "coupling,t_s,overlap_m,force_N,energy_J,residual_N,ejected");
  for (const PileRun& run : runs)
    for (const PileSample& s : run.samples)
      csv.row(run.coupling, s.t, s.overlap, s.force, s.energy, s.residual, s.ejected);
}

}  // namespace godobject::study
