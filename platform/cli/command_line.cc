#include "platform/cli/command_line.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <string>

#include "platform/scene/text/key.h"

namespace godobject {
namespace {

CLI::Validator number(const Range& range) {
  const auto check = [range](const std::string& text) -> std::string {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool complete = error == std::errc() && end == text.data() + text.size();
    return complete && range.contains(value) ? "" : "'" + text + "' is not a number " + to_string(range);
  };
  return {check, to_string(range), "number"};
}

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

/// Escapes text for roff, so that no dash becomes a hyphen and no line a request.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') out += "\\e";
    else if (c == '-') out += "\\-";
    else if ((c == '.' || c == '\'') && out.empty()) out += std::string("\\&") + c;
    else out += c;
  }
  return out;
}

void add_options(std::string& page, const CLI::App& verb) {
  for (const CLI::Option* option : options_of(verb)) {
    const OptionText text = text_of(*option);
    page += ".TP\n\\fB" + roff(text.names) + "\\fR";
    if (!text.value.empty()) page += " \\fI" + roff(text.value) + "\\fR";
    page += "\n" + roff(text.about) + "\n";
  }
}

void add_verb(std::string& page, const CLI::App& verb, const std::string& path) {
  page += ".SS " + roff(path) + "\n" + roff(verb.get_description()) + "\n";
  add_options(page, verb);
  const CLI::App* const parent = verb.get_parent();  // a parent passes its own footer to its verbs
  if (parent != nullptr && verb.get_footer() != parent->get_footer())
    page += ".PP\n" + roff(verb.get_footer()) + "\n";
  for (const CLI::App* sub : verbs_of(verb)) add_verb(page, *sub, path + " " + sub->get_name());
}

/// Returns a manual page up to its synopsis. about: line of the NAME section, whose full stop is removed.
std::string man_head(const std::string& name, std::string about, const std::string& version) {
  std::string title = roff(name);
  std::ranges::transform(title, title.begin(),
                         [](char c) { return 'a' <= c && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  if (about.ends_with('.')) about.pop_back();
  return ".TH " + title + " 1 \"\" \"godobject " + roff(version) + "\"\n.SH NAME\n" + roff(name) + " \\- " +
         roff(about) + "\n.SH SYNOPSIS\n";
}

/// Branches of the three `case` statements of the completion.
struct Cases {
  std::string paths;   // words that lead to a verb
  std::string values;  // words that may follow an option
  std::string words;   // words of a verb
};

std::vector<std::string> names_of(const CLI::Option& option) {
  return CLI::detail::split(option.get_name(false, true), ',');
}

void add_cases(Cases& cases, const CLI::App& verb, const std::string& path) {
  std::string words;
  for (const CLI::App* sub : verbs_of(verb)) {
    words += sub->get_name() + " ";
    cases.paths +=
        "      '" + path + " " + sub->get_name() + "') path='" + path + " " + sub->get_name() + "' ;;\n";
    add_cases(cases, *sub, path + " " + sub->get_name());
  }
  for (const CLI::Option* option : options_of(verb)) {
    std::string choices;
    for (const std::string& choice : text_of(*option).choices) choices += choice + " ";
    if (option->get_positional()) words += choices;
    if (option->get_positional()) continue;
    for (const std::string& name : names_of(*option)) {
      words += name + " ";
      if (!choices.empty()) cases.values += "    '" + path + " " + name + "') words='" + choices + "' ;;\n";
    }
  }
  cases.words += "    '" + path + "') words='" + words + "' ;;\n";
}

}  // namespace

CLI::Validator number_in(double min, double max) { return number({.min = min, .max = max}); }
CLI::Validator number_above(double min, double max) {
  return number({.min = min, .max = max, .min_open = true});
}

CLI::Validator port_number() {
  constexpr unsigned highest = 65535;
  const auto check = [](const std::string& text) -> std::string {
    unsigned port = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
    const bool complete =
        error == std::errc() && end == text.data() + text.size() && port >= 1 && port <= highest;
    return text.empty() || complete
               ? ""
               : "'" + text + "' is not a port number, 1 to 65535; write SCENE before --view";
  };
  return {check, "", "port"};
}

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

std::string man_page(const CLI::App& app, const std::string& version) {
  std::string page = man_head("godobject", app.get_description(), version) +
                     "\\fBgodobject\\fR \\fIVERB\\fR [\\fIOPTIONS\\fR]\n.SH OPTIONS\n";
  add_options(page, app);
  page += ".SH VERBS\n";
  for (const CLI::App* verb : verbs_of(app)) add_verb(page, *verb, verb->get_name());
  return page + ".SH EXIT STATUS\n" + roff(app.get_footer()) + "\n";
}

std::string man_page_of_verb(const CLI::App& app, const CLI::App& verb, const std::string& version) {
  const std::string& name = verb.get_name();
  std::string page = man_head("godobject-" + name, verb.get_description(), version) + "\\fBgodobject " +
                     roff(name) + "\\fR [\\fIOPTIONS\\fR]";
  for (const CLI::Option* option : options_of(verb))
    if (option->get_positional()) page += " \\fI" + roff(option->get_name(true, false)) + "\\fR";
  page += verbs_of(verb).empty() ? "\n" : " \\fIVERB\\fR\n";
  if (verb.get_footer() != app.get_footer()) page += ".SH DESCRIPTION\n" + roff(verb.get_footer()) + "\n";
  page += ".SH OPTIONS\n";
  add_options(page, verb);
  if (!verbs_of(verb).empty()) page += ".SH VERBS\n";
  for (const CLI::App* sub : verbs_of(verb)) add_verb(page, *sub, name + " " + sub->get_name());
  return page + ".SH EXIT STATUS\n" + roff(app.get_footer()) + "\n.SH SEE ALSO\n\\fBgodobject\\fR(1)\n";
}

std::string bash_completion(const CLI::App& app) {
  Cases cases;
  add_cases(cases, app, "");
  return R"(# bash completion of godobject; made by: godobject completion bash
_godobject() {
  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD-1]} path='' words='' word
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    case "$path $word" in
)" + cases.paths +
         R"(    esac
  done
  COMPREPLY=()
  case "$path $prev" in
)" + cases.values +
         R"(  esac
  if [[ -n $words ]]; then
    COMPREPLY=($(compgen -W "$words" -- "$cur"))
    return
  fi
  case "$path" in
)" + cases.words +
         R"(  esac
  COMPREPLY=($(compgen -W "$words" -- "$cur"))
  [[ $cur == -* ]] || COMPREPLY+=($(compgen -f -- "$cur"))
}
complete -o filenames -F _godobject godobject
)";
}

bool write_file(const std::string& option, const std::string& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  out.close();
  if (!out)
    std::fprintf(stderr, "%s: '%s' could not be written: check its folder and the disk\n", option.c_str(),
                 path.c_str());
  return !out.fail();
}

}  // namespace godobject
