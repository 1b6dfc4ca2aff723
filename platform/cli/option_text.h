// The command line in words: what help, manual page and shell completion say of an option.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace godobject {

struct OptionText {
  std::string names;  // "-h,--help"; of a positional its name
  std::string value;  // "FILE", "never|auto"; empty: a flag
  std::string about;  // what it does, with what is admissible, the default, whether it is required
  std::vector<std::string> choices;  // the values, where only some are admissible
};

OptionText text_of(const CLI::Option& option);

/// The options of a verb, in their order; positionals first.
std::vector<const CLI::Option*> options_of(const CLI::App& verb);
/// Those that help lists.
std::vector<const CLI::App*> verbs_of(const CLI::App& app);

/// Broken between words into lines of at most `width`; each but the first begins with `indent` spaces.
std::string wrapped(const std::string& text, std::size_t width, std::size_t indent);

/// Help in 80 columns.
class HelpFormat : public CLI::Formatter {
 public:
  std::string make_option(const CLI::Option* option, bool is_positional) const override;
  std::string make_subcommand(const CLI::App* verb) const override;
  std::string make_description(const CLI::App* app) const override;
  std::string make_footer(const CLI::App* app) const override;
};

}  // namespace godobject
