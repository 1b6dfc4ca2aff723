// Figures of contacts, in addition to plots.h.
#pragma once

#include <filesystem>
#include <vector>

#include "tests/study/contact/error.h"
#include "tests/study/contact/stability.h"

namespace godobject::study {

void write_contact_error_script(const std::filesystem::path& directory,
                                const std::vector<ContactErrorRow>& rows);
void write_contact_stability_script(const std::filesystem::path& directory, const ContactGrid& grid);
void write_contact_imposed_script(const std::filesystem::path& directory);

}  // namespace godobject::study
