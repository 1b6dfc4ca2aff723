#include "platform/cli/command_documents.h"

#include "platform/cli/option_text.h"

namespace godobject {
namespace {

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
  for (const CLI::App* sub : verbs_of(verb)) add_verb(page, *sub, path + " " + sub->get_name());
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

std::string man_page(const CLI::App& app, const std::string& version) {
  std::string page = ".TH GODOBJECT 1 \"\" \"godobject " + roff(version) + "\"\n.SH NAME\ngodobject \\- " +
                     roff(app.get_description()) +
                     "\n.SH SYNOPSIS\n\\fBgodobject\\fR \\fIVERB\\fR [\\fIOPTIONS\\fR]\n.SH OPTIONS\n";
  add_options(page, app);
  page += ".SH VERBS\n";
  for (const CLI::App* verb : verbs_of(app)) add_verb(page, *verb, verb->get_name());
  return page + ".SH EXIT STATUS\n" + roff(app.get_footer()) + "\n";
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

}  // namespace godobject
