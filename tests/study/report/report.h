// Report: question, result, method. Every number comes from the results.
#pragma once

#include "tests/study/study.h"

namespace godobject::study {

/// Writes options.report and copies the figures to figures/ beside it. The results must have all parts.
void write_report(const StudyOptions& options, const StudyResults& results);

}  // namespace godobject::study
