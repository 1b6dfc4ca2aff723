// Results chapter of the report: one section per part.
#pragma once

#include <ostream>

#include "tests/study/study.h"

namespace godobject::study {

void write_error(std::ostream& out, const std::vector<ErrorRow>& rows);
/// Writes the comparison of write_error() on random scenes.
void write_random(std::ostream& out, const std::vector<RandomRow>& rows);
void write_extremes(std::ostream& out, const std::vector<ExtremeMap>& maps);
void write_nets(std::ostream& out, const NetResults& nets);
void write_stability(std::ostream& out, const StudyResults& results);
void write_joints(std::ostream& out, const StudyResults& results);
void write_contacts(std::ostream& out, const StudyResults& results);
void write_footprint(std::ostream& out, const std::vector<FootprintRow>& rows);

}  // namespace godobject::study
