#include "platform/cli/option_text.h"

#include <algorithm>

namespace godobject {
namespace {

constexpr std::size_t help_width = 80, about_column = 28;

/// Translates CLI11's text of a constraint.
std::string constraint_text(std::string text) {
  if (text == "POSITIVE") return "> 0";
  const std::string range = "INT in [";
  if (!text.starts_with(range)) return text;
  text = text.substr(range.size(), text.size() - range.size() - 1);
  const std::size_t dash = text.find(" - ");
  return text.replace(dash, 3, " to ");
}

std::string type_text(const std::string& type) {
  if (type == "FLOAT") return "NUMBER";
  return type == "INT" || type == "UINT" ? "N" : type;
}

std::string joined(const std::vector<std::string>& words, const char* between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

/// Returns a name in the left column with its text beside it, or below it if the name is long.
std::string entry(const std::string& name, const std::string& about) {
  const std::string left = "  " + name;
  const std::string gap = left.size() + 2 > about_column ? "\n" + std::string(about_column, ' ')
                                                         : std::string(about_column - left.size(), ' ');
  return left + gap + wrapped(about, help_width - about_column, about_column) + "\n";
}

}  // namespace

OptionText text_of(const CLI::Option& option) {
  OptionText text{
      .names = option.get_positional() ? option.get_name(true, false) : option.get_name(false, true),
      .value = "",
      .about = option.get_description(),
      .choices = {}};
  if (option.get_expected_max() == 0) return text;
  const std::string full = option.get_type_name();
  const std::size_t colon = full.find(':');
  std::string constraint = colon == std::string::npos ? "" : full.substr(colon + 1);
  text.value = type_text(full.substr(0, colon));
  if (constraint.starts_with('{') && constraint.ends_with('}')) {
    text.choices = CLI::detail::split(constraint.substr(1, constraint.size() - 2), ',');
    text.value = joined(text.choices, "|");
    constraint.clear();
  }
  std::vector<std::string> more;
  if (!constraint.empty()) more.push_back(constraint_text(constraint));
  if (!option.get_default_str().empty()) more.push_back("default " + option.get_default_str());
  if (option.get_required()) more.emplace_back("required");
  const bool repeats = option.get_expected_max() >= CLI::detail::expected_max_vector_size ||
                       option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
  if (repeats) more.emplace_back("may be repeated");
  if (!more.empty()) text.about += " (" + joined(more, ", ") + ")";
  return text;
}

std::vector<const CLI::Option*> options_of(const CLI::App& verb) {
  std::vector<const CLI::Option*> options =
      verb.get_options([](const CLI::Option* option) { return !option->get_group().empty(); });
  std::stable_partition(options.begin(), options.end(),
                        [](const CLI::Option* option) { return option->get_positional(); });
  return options;
}

std::vector<const CLI::App*> verbs_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* verb) { return !verb->get_group().empty(); });
}

std::string wrapped(const std::string& text, std::size_t width, std::size_t indent) {
  std::string lines;
  std::size_t used = 0;
  for (const std::string& word : CLI::detail::split(text, ' ')) {
    const bool breaks = used > 0 && used + 1 + word.size() > width;
    if (breaks) lines += "\n" + std::string(indent, ' ');
    else if (used > 0) lines += ' ';
    used = breaks ? word.size() : used + word.size() + (used > 0 ? 1 : 0);
    lines += word;
  }
  return lines;
}

std::string HelpFormat::make_option(const CLI::Option* option, bool is_positional) const {
  const OptionText text = text_of(*option);
  const bool shows_value = !text.value.empty() && !(is_positional && text.value == "TEXT");
  return entry(text.names + (shows_value ? " " + text.value : ""), text.about);
}

std::string HelpFormat::make_subcommand(const CLI::App* verb) const {
  return entry(verb->get_name(), verb->get_description());
}

std::string HelpFormat::make_description(const CLI::App* app) const {
  return wrapped(app->get_description(), help_width, 0) + "\n";
}

std::string HelpFormat::make_footer(const CLI::App* app) const {
  return wrapped(app->get_footer(), help_width - 2, 2) + "\n";
}

}  // namespace godobject
