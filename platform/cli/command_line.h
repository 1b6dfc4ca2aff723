// Options of the command line: checks of their values, and their text in help, manual page and shell
// completion.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace godobject {

// Checks of CLI11 itself accept NaN and do not name the admissible values.

/// Requires a number in [min, max].
CLI::Validator number_in(double min, double max);
/// Requires a number in (min, max].
CLI::Validator number_above(double min, double max);
/// Requires a TCP port, or an empty text.
CLI::Validator port_number();

struct OptionText {
  std::string names;                 // "-h,--help"; name of a positional
  std::string value;                 // "FILE", "never|auto"; empty for a flag
  std::string about;                 // description, admissible values, default, and whether it is required
  std::vector<std::string> choices;  // admissible values, if there are only some
};

OptionText text_of(const CLI::Option& option);

/// Returns the options of a verb in their order, positionals first.
std::vector<const CLI::Option*> options_of(const CLI::App& verb);
/// Returns the verbs that help lists.
std::vector<const CLI::App*> verbs_of(const CLI::App& app);

/// Writes the file that an option names. Prints the error and returns false if this fails.
bool write_file(const std::string& option, const std::string& path, const std::string& text);

/// Breaks text between words into lines of at most `width`; each but the first begins with `indent` spaces.
std::string wrapped(const std::string& text, std::size_t width, std::size_t indent);

/// Formats help in 80 columns.
class HelpFormat : public CLI::Formatter {
 public:
  std::string make_option(const CLI::Option* option, bool is_positional) const override;
  std::string make_subcommand(const CLI::App* verb) const override;
  std::string make_description(const CLI::App* app) const override;
  std::string make_footer(const CLI::App* app) const override;
};

/// Returns the manual page in roff, section 1.
std::string man_page(const CLI::App& app, const std::string& version);
/// Returns the manual page of one verb of the program: godobject-run(1).
std::string man_page_of_verb(const CLI::App& app, const CLI::App& verb, const std::string& version);

/// Returns the completion of bash for verbs, options and the values of options; elsewhere it completes file
/// names.
std::string bash_completion(const CLI::App& app);

}  // namespace godobject
