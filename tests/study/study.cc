#include "tests/study/study.h"

#include <sstream>
#include <stdexcept>

#include "tests/study/contact/plots.h"
#include "tests/study/plots.h"
#include "tests/study/reference_solution.h"
#include "tests/study/report/report.h"
#include "tests/study/tool.h"

namespace godobject::study {
namespace {

namespace fs = std::filesystem;

class Study {
 public:
  Study(const StudyOptions& options, const Progress& progress)
      : options_(options),
        progress_(progress),
        probes_(options.probe_directory.empty() ? default_probe_directory() : options.probe_directory),
        counter_(probe_program(probes_, options.quick)),
        can_draw_(tool_exists("gnuplot")) {
    fs::create_directories(options.out);
    if (!can_draw_) results_.notes.emplace_back("no figures: gnuplot is not installed");
    const bool counts =
        options.error || options.footprint || options.joints || options.contacts || options.nets;
    if (counts && !counter_.why_not().empty())
      results_.notes.push_back("no instruction counts: " + counter_.why_not());
  }

  void error() {
    const std::vector<ReferenceScene> scenes = reference_scenes();
    results_.errors = study_error(scenes, options_.quick, counter_, progress_);
    write_csv(options_.out / "error.csv", results_.errors);
    write_error_script(options_.out, results_.errors);
    figure("error");
    results_.random = study_random(options_.quick, progress_);
    write_csv(options_.out / "error-random.csv", results_.random);
  }

  void stability() {
    const StabilityGrid grid = stability_grid(options_.quick);
    results_.stability = study_stability(grid, progress_);
    write_csv(options_.out / "stability.csv", results_.stability);
    for (const double damping : grid.dampings)
      results_.explicit_limits.push_back({damping, measured_explicit_limit(damping)});
    for (std::size_t i = 0; i < stability_schemes.size(); ++i) {
      write_stability_script(options_.out, i, grid);
      figure(std::string("stability-") + stability_schemes[i]);
    }
    results_.extremes = study_extremes(options_.quick, progress_);
    for (const ExtremeMap& map : results_.extremes) {
      write_csv(options_.out / (figure_of(map) + ".csv"), map);
      write_extreme_script(options_.out, map);
      figure(figure_of(map));
    }
  }

  void footprint() {
    std::string why_not;
    results_.footprint = study_footprint(probes_, options_.quick, counter_, progress_, why_not);
    if (!why_not.empty()) {
      results_.notes.push_back("no footprint: " + why_not);
      return;
    }
    write_csv(options_.out / "footprint.csv", results_.footprint);
    write_footprint_script(options_.out, results_.footprint);
    figure("footprint");
  }

  void joints() {
    results_.joint_drift = study_drift(options_.quick, progress_);
    write_drift_csv(options_.out / "joint-drift.csv", results_.joint_drift);
    write_drift_script(options_.out);
    figure("joint-drift");
    const JointGrid grid = joint_grid(options_.quick);
    results_.joint_stability = study_joint_stability(grid, progress_);
    write_joint_stability_csv(options_.out / "joint-stability.csv", results_.joint_stability);
    write_joint_stability_script(options_.out, grid);
    figure("joint-stability");
    results_.s3_reference_error = reference_error(reference_s3());
    std::string why_not;
    results_.joint_costs = study_joint_costs(probes_, options_.quick, counter_, progress_, why_not);
    if (!why_not.empty()) results_.notes.push_back("no cost of joints: " + why_not);
    write_csv(options_.out / "joint-cost.csv", results_.joint_costs);
  }

  void contacts() {
    results_.contact_errors = study_contact_errors(contact_cases(), options_.quick, progress_);
    write_csv(options_.out / "contact-error.csv", results_.contact_errors.rows);
    write_contact_error_script(options_.out, results_.contact_errors.rows);
    figure("contact-error");
    const ContactGrid grid = contact_grid(options_.quick);
    results_.contact_stability = study_contact_stability(grid, progress_);
    write_csv(options_.out / "contact-stability.csv", results_.contact_stability);
    write_contact_stability_script(options_.out, grid);
    figure("contact-stability");
    const fs::path& scenes = options_.scene_directory;
    results_.piles =
        study_imposed(scenes.empty() ? default_scene_directory() : scenes, options_.quick, progress_);
    write_csv(options_.out / "contact-imposed.csv", results_.piles);
    write_contact_imposed_script(options_.out);
    figure("contact-imposed");
    std::string why_not;
    results_.contact_costs = study_contact_costs(probes_, options_.quick, counter_, progress_, why_not);
    if (!why_not.empty()) results_.notes.push_back("no cost of contacts: " + why_not);
    write_csv(options_.out / "contact-cost.csv", results_.contact_costs);
  }

  void nets() {
    results_.nets = study_nets(options_.quick, counter_, progress_);
    write_csv(options_.out / "net-error.csv", results_.nets.errors);
    write_csv(options_.out / "net-cost.csv", results_.nets.costs);
    write_net_script(options_.out);
    figure("net-error");
  }

  StudyResults results() && { return std::move(results_); }

 private:
  void figure(const std::string& name) {
    if (!can_draw_) return;
    progress_("drawing " + name);
    const std::string problem = draw(options_.out, name);
    if (!problem.empty()) throw std::runtime_error(problem);
  }

  const StudyOptions& options_;
  const Progress& progress_;
  fs::path probes_;
  InstructionCounter counter_;
  bool can_draw_;
  StudyResults results_;
};

}  // namespace

StudyResults run_study(const StudyOptions& options, const Progress& progress) {
  Study study(options, progress);
  if (options.error) study.error();
  if (options.stability) study.stability();
  if (options.footprint) study.footprint();
  if (options.joints) study.joints();
  if (options.contacts) study.contacts();
  if (options.nets) study.nets();
  StudyResults results = std::move(study).results();
  if (!options.report.empty()) write_report(options, results);
  return results;
}

fs::path default_scene_directory() { return GODOBJECT_SCENE_DIRECTORY; }

std::string build_description() {
  std::istringstream flags(GODOBJECT_FLAGS);
  std::string text = GODOBJECT_COMPILER;
  for (std::string flag; flags >> flag;)
    if (!flag.starts_with("-W")) text += " " + flag;
  return text;
}

}  // namespace godobject::study
