#include "tests/study/joint/cost_study.h"

#include <algorithm>

#include "core/godobject.h"
#include "tests/study/compositions.h"
#include "tests/study/csv_writer.h"
#include "tests/support/stabilisation.h"

namespace godobject::study {
namespace {

constexpr std::size_t most_links_counted = 64;  // limits the run time of callgrind

JointCostRow cost_of(const FootprintRow& size, const std::string& motion, std::size_t num_bodies) {
  return {.composition = size.composition,
          .motion = motion,
          .num_bodies = num_bodies,
          .params_bytes = size.params_bytes,
          .state_bytes = size.state_bytes,
          .scratch_bytes = size.scratch_bytes,
          .code_bytes = size.code_bytes,
          .constant_bytes = size.constant_bytes,
          .instructions = {},
          .instructions_slow = {}};
}

void count(InstructionCounter& counter, const Progress& progress, JointCostRow& row) {
  progress("joints: instructions, " + row.composition + " on " + row.motion);
  row.instructions = counter.per_step(row.composition, row.motion);
  row.instructions_slow = counter.per_step(row.composition, row.motion + "-slow");
}

/// Returns the compositions with their scenes: S3 with four bodies, or S5 with as many links as fit.
std::vector<JointCostRow> compositions_of(const std::vector<FootprintRow>& sizes) {
  std::vector<JointCostRow> rows;
  for (const FootprintRow& size : sizes) {
    if (size.composition.starts_with("free-joints")) rows.push_back(cost_of(size, "s5", size.max_bodies));
    else if (size.max_bodies == 4) rows.push_back(cost_of(size, "s3", 4));
  }
  return rows;
}

std::vector<JointCostRow> kinds_of(const std::vector<FootprintRow>& sizes) {
  std::vector<JointCostRow> rows;
  for (const char* kind : {"free", "fixed", "ball", "hinge", "slider", "cylindrical", "universal"})
    for (const FootprintRow& size : sizes)
      if (size.composition.starts_with("pose-joints-2"))
        rows.push_back(cost_of(size, std::string("pair-") + kind, 2));
  return rows;
}

/// Returns the bytes of a component: `With` has it, `Without` does not.
template <class With, class Without>
PartBytes difference(const char* part) {
  constexpr std::size_t N = With::max_bodies;
  return {.part = part,
          .params = (sizeof(Params<With>) - sizeof(Params<Without>)) / N,
          .state = (sizeof(State<With>) - sizeof(State<Without>)) / N,
          .scratch = (sizeof(Scratch<With>) - sizeof(Scratch<Without>)) / N};
}

std::vector<PartBytes> parts_of() {
  using I = ImplicitEuler;
  return {difference<Tool<I, 8>, Follower<I, 8>>("joints"),
          difference<ToolWithStops<I, 8>, Tool<I, 8>>("their stops"),
          difference<ToolWithImposed<I, 8>, Tool<I, 8>>("imposed ones"),
          difference<ToolHeldBy<I, 8, AtBase>, Tool<I, 8>>("a stabilisation that uses the base")};
}

}  // namespace

JointCosts study_joint_costs(const std::filesystem::path& probe_directory, bool quick,
                             InstructionCounter& counter, const Progress& progress, std::string& why_not) {
  const std::vector<FootprintRow> sizes =
      list_compositions(probe_directory, quick, Family::articulated, why_not);
  JointCosts costs{.compositions = compositions_of(sizes), .kinds = kinds_of(sizes), .parts = parts_of()};
  if (quick) return costs;
  for (JointCostRow& row : costs.compositions)
    if (row.num_bodies <= most_links_counted) count(counter, progress, row);
  for (JointCostRow& row : costs.kinds) count(counter, progress, row);
  return costs;
}

void write_csv(const std::filesystem::path& file, const JointCosts& costs) {
  CsvWriter csv(file,
                "composition,motion,bodies,params_bytes,state_bytes,scratch_bytes,code_bytes,constant_bytes,"
                "instructions,instructions_slow_motion");
  for (const auto* rows : {&costs.compositions, &costs.kinds})
    for (const JointCostRow& r : *rows)
      csv.row(r.composition, r.motion, r.num_bodies, r.params_bytes, r.state_bytes, r.scratch_bytes,
              r.code_bytes, r.constant_bytes, r.instructions, r.instructions_slow);
}

}  // namespace godobject::study
