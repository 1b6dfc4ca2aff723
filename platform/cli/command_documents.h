// Documents that a packager installs beside the program, generated from the description of the command line.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace godobject {

/// Returns the manual page in roff, section 1.
std::string man_page(const CLI::App& app, const std::string& version);

/// Returns the completion of bash for verbs, options and the values of options; elsewhere it completes file
/// names.
std::string bash_completion(const CLI::App& app);

}  // namespace godobject
