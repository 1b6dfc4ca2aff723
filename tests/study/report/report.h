// The report: what was asked, the result, how it was found. Every number in it comes from the results.
#pragma once

#include "tests/study/study.h"

namespace godobject::study {

/// Writes options.report and copies the figures to the folder figures/ beside it. The results have all parts.
void write_report(const StudyOptions& options, const StudyResults& results);

}  // namespace godobject::study
