// What a packager installs beside the program: made from the description of the command line, so that it cannot say
// anything else.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace godobject {

/// In roff, section 1.
std::string man_page(const CLI::App& app, const std::string& version);

/// It completes verbs, options and the values of options; file names elsewhere.
std::string bash_completion(const CLI::App& app);

}  // namespace godobject
