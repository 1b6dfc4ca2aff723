#include <algorithm>

#include "core/integrator_implicit_euler.h"
#include "core/integrator_tr_bdf2.h"
#include "tests/study/report/results.h"
#include "tests/study/report/text.h"

namespace godobject::study {
namespace {

std::string drift_text(const JointRun& r) {
  if (r.failed) return "failed after " + std::to_string(r.steps) + " steps | |";
  return number(r.drift.m, 2) + " | " + number(r.drift.rad, 2) + " |";
}

/// Writes the drift of the grasper's joints, one line per scheme.
void write_drift(std::ostream& out, const std::vector<JointRun>& rows) {
  out << "S3 is a grasper of four bodies on four joints, S5 five equal links on ball joints, chain-5 the "
         "same with an end ten times heavier. Their errors and drifts are in 1.\n\n"
         "What holds the joints, on S3 over 2 s at 1 ms; other steps in `joint-drift.csv`:\n\n"
         "| scheme | drift, m | drift, rad | position error, m |\n|---|---|---|---|\n";
  for (const JointRun& r : rows)
    if (is_one_ms(r.h))
      out << "| " << r.scheme << " | " << drift_text(r) << ' '
          << (r.failed ? "" : number(r.errors.position, 2)) << " |\n";
  out << "\n![joint drift](figures/joint-drift.png)\n\n";
}

void write_map(std::ostream& out, const std::vector<JointRun>& rows) {
  out << "Over coupling stiffness and step, 1000 steps each:\n\n"
         "| scheme | cells | failed | failed after, steps | worst drift, m | up to 1 ms "
         "|\n|---|---|---|---|---|---|\n";
  for (const std::string& scheme : joint_schemes()) {
    std::size_t cells = 0, failed = 0, latest = 0;
    double drift = 0, drift_1ms = 0;
    for (const JointRun& r : rows) {
      if (r.scheme != scheme) continue;
      ++cells;
      failed += r.failed ? 1 : 0;
      if (r.failed) latest = std::max(latest, r.steps + 1);
      drift = std::max(drift, r.drift.m);
      if (r.h <= 1.001e-3) drift_1ms = std::max(drift_1ms, r.drift.m);
    }
    out << "| " << scheme << " | " << cells << " | " << failed << " | ";
    if (failed > 0) out << "at most " << latest << " | - | - |\n";
    else out << "- | " << number(drift, 2) << " | " << number(drift_1ms, 2) << " |\n";
  }
  out << "\n![joint stability](figures/joint-stability.png)\n\n";
}

const JointCostRow* find(const std::vector<JointCostRow>& rows, const std::string& composition,
                         const std::string& motion) {
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const JointCostRow& r) {
    return r.composition == composition && r.motion == motion;
  });
  return row == rows.end() ? nullptr : &*row;
}

void write_parts(std::ostream& out, const std::vector<PartBytes>& parts) {
  out << "Bytes of a body, more than without, of params, state and scratch:\n\n";
  for (const PartBytes& p : parts)
    out << "- " << p.part << ": " << p.params << ", " << p.state << ", " << p.scratch << '\n';
  out << '\n';
}

std::string counts(const JointCostRow* row) {
  return row == nullptr ? "not available" : whole(row->instructions);
}

void write_kinds(std::ostream& out, const std::vector<JointCostRow>& kinds) {
  const std::string euler = std::string("pose-joints-2 ") + ImplicitEuler::name,
                    second = std::string("pose-joints-2 ") + TrBdf2::name;
  out << "Instructions of a step of two coupled bodies with one joint between them, " << ImplicitEuler::name
      << " and " << TrBdf2::name << ":\n\n";
  for (const JointCostRow& r : kinds) {
    if (r.composition != euler) continue;
    out << "- " << r.motion.substr(5) << ": " << counts(&r) << ", " << counts(find(kinds, second, r.motion))
        << '\n';
  }
  out << '\n';
}

/// Writes the instructions of a link in short and long chains.
void write_links(std::ostream& out, const std::vector<JointCostRow>& rows) {
  out << "Instructions a link of S5 in a step:";
  std::string separator = " ";
  for (const JointCostRow& r : rows) {
    if (!r.composition.starts_with("free-joints-") || r.num_bodies == 1 || !r.instructions) continue;
    out << separator << whole(*r.instructions / static_cast<double>(r.num_bodies)) << " of " << r.num_bodies
        << " links (" << r.composition.substr(r.composition.find(' ') + 1) << ")";
    separator = ", ";
  }
  out << (separator == " " ? " not available" : "")
      << ". Bytes and instructions of all compositions: `joint-cost.csv`.\n\n";
}

}  // namespace

void write_joints(std::ostream& out, const StudyResults& results) {
  out << "### 4. Articulated tools\n\n";
  write_drift(out, results.joint_drift);
  write_map(out, results.joint_stability);
  out << "What joints cost. ";
  write_parts(out, results.joint_costs.parts);
  if (results.joint_costs.compositions.empty()) return;
  write_kinds(out, results.joint_costs.kinds);
  write_links(out, results.joint_costs.compositions);
}

}  // namespace godobject::study
