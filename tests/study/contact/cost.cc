#include "tests/study/contact/cost.h"

#include "tests/study/csv_writer.h"

namespace godobject::study {

std::vector<ContactCostRow> study_contact_costs(const std::filesystem::path& probe_directory, bool quick,
                                                InstructionCounter& counter, const Progress& progress,
                                                std::string& why_not) {
  std::vector<ContactCostRow> rows;
  for (const FootprintRow& size : list_compositions(probe_directory, quick, Family::touching, why_not)) {
    if (size.composition.starts_with("bricks")) rows.push_back({size, "s4", {}});
    else rows.push_back({size, "s2", {}});
    if (size.composition.starts_with("pressed-contacts")) rows.push_back({size, "s2-smooth", {}});
  }
  if (quick) return rows;
  for (ContactCostRow& row : rows) {
    progress("contacts: instructions, " + row.size.composition + " on " + row.motion);
    row.instructions = counter.per_step(row.size.composition, row.motion);
  }
  return rows;
}

void write_csv(const std::filesystem::path& file, const std::vector<ContactCostRow>& rows) {
  CsvWriter csv(
      file,
      "composition,motion,params_bytes,state_bytes,scratch_bytes,code_bytes,constant_bytes,instructions");
  for (const ContactCostRow& r : rows)
    csv.row(r.size.composition, r.motion, r.size.params_bytes, r.size.state_bytes, r.size.scratch_bytes,
            r.size.code_bytes, r.size.constant_bytes, r.instructions);
}

}  // namespace godobject::study
