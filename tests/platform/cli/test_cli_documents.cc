// Help, manual page and completion of the program, from one description.
#include <gmock/gmock.h>

#include <functional>
#include <regex>
#include <sstream>

#include "platform/cli/command_line.h"
#include "platform/cli/program.h"
#include "platform/simulated/session.h"
#include "tests/support/program.h"

namespace godobject::test::test_cli_documents {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Calls `use` for every verb with its path: "lss node-id".
void for_each_verb(const CLI::App& app, const std::string& path,
                   const std::function<void(const std::string&, const CLI::App&)>& use) {
  use(path, app);
  for (const CLI::App* verb :
       app.get_subcommands([](const CLI::App* sub) { return !sub->get_group().empty(); }))
    for_each_verb(*verb, path.empty() ? verb->get_name() : path + " " + verb->get_name(), use);
}

class CliDocuments : public ProgramTest {
 protected:
  CliDocuments() { add_verbs(app_, {.simulated = simulated_devices(), .add_verb = add_simulate}, code_); }
  std::string completed(const std::string& words) const {
    const std::string script =
        "source <('" GODOBJECT_PROGRAM "' completion bash); COMP_WORDS=(" + words +
        "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _godobject; printf '[%s]' \"${COMPREPLY[@]}\"";
    const std::string file = write("complete.sh", script);
    ProgramResult result;
    std::FILE* const pipe = popen(("cd '" GODOBJECT_SOURCE_DIR "' && bash '" + file + "' 2>&1").c_str(), "r");
    std::array<char, 4096> buffer{};
    for (std::size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
      result.output.append(buffer.data(), n);
    pclose(pipe);
    return result.output;
  }

  ExitCode code_ = ExitCode::ok;
  CLI::App app_{"about", "godobject"};
};

TEST_F(CliDocuments, TheManualPageListsEveryVerbAndOption) {
  const ProgramResult man = run_program("man");
  ASSERT_EQ(man.exit_code, 0);
  EXPECT_THAT(man.output, testing::StartsWith(".TH GODOBJECT 1"));
  const auto roff = [](std::string text) {
    for (std::size_t at = 0; (at = text.find('-', at)) != std::string::npos; at += 2) text.insert(at, "\\");
    return text;
  };
  std::size_t num_options = 0;
  for_each_verb(app_, "", [&](const std::string& path, const CLI::App& verb) {
    if (!path.empty()) {
      EXPECT_THAT(man.output, HasSubstr(".SS " + roff(path) + "\n"));
    }
    const std::size_t section = path.empty() ? 0 : man.output.find(".SS " + roff(path) + "\n");
    const std::string part = man.output.substr(section, man.output.find(".SS ", section + 4) - section);
    for (const CLI::Option* option : verb.get_options()) {
      ++num_options;
      EXPECT_THAT(part, HasSubstr("\\fB" + roff(option->get_positional() ? option->get_name(true, false)
                                                                         : option->get_name(false, true))))
          << path;
    }
  });
  EXPECT_GT(num_options, 60u);
}

TEST_F(CliDocuments, EveryVerbHasAManualPageOfItsOwn) {
  for (const CLI::App* verb : verbs_of(app_)) {
    const std::string& name = verb->get_name();
    const ProgramResult man = run_program("man " + name);
    ASSERT_EQ(man.exit_code, 0) << name;
    const std::string page = std::regex_replace(man.output, std::regex(R"(\\-)"), "-");
    EXPECT_THAT(page, HasSubstr(".SH NAME\ngodobject-" + name + " - ")) << name;
    for_each_verb(*verb, name, [&](const std::string& path, const CLI::App& part) {
      for (const CLI::Option* option : part.get_options())
        EXPECT_THAT(page, HasSubstr("\\fB" + (option->get_positional() ? option->get_name(true, false)
                                                                       : option->get_name(false, true))))
            << path;
    });
  }
  const ProgramResult unknown = run_program("man nosuch");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.output, HasSubstr("nosuch not in {run,check,"));
}

TEST_F(CliDocuments, AVerbWithATextOfItsOwnHasItInHelpAndManualPage) {
  const ProgramResult man = run_program("man");
  for (const std::string verb : {"metrics", "doctor"}) {
    const std::string text = app_.get_subcommand(verb)->get_footer();
    EXPECT_NE(text, app_.get_footer());
    EXPECT_THAT(man.output, HasSubstr(text.substr(0, 24)));
    EXPECT_THAT(run_program(verb + " --help").output, HasSubstr(text.substr(0, 24)));
  }
  EXPECT_THAT(run_program("check --help").output, HasSubstr("Exit codes: 0 ok, 1 fault"));
}

TEST_F(CliDocuments, CompletionHasVerbsOptionsAndValues) {
  if (std::system("bash -c true") != 0) GTEST_SKIP() << "no bash here";
  for_each_verb(app_, "", [&](const std::string& path, const CLI::App& verb) {
    const std::string words = completed("godobject " + path + " ''"),
                      options = completed("godobject " + path + " -");
    for (const CLI::App* sub :
         verb.get_subcommands([](const CLI::App* s) { return !s->get_group().empty(); }))
      EXPECT_THAT(words, HasSubstr("[" + sub->get_name() + "]")) << path;
    for (const CLI::Option* option : verb.get_options())
      for (const std::string& name : option->get_lnames())
        EXPECT_THAT(options, HasSubstr("[--" + name + "]")) << path;
  });
  EXPECT_EQ(completed("godobject mon"), "[monitor]");
  EXPECT_EQ(completed("godobject run x.toml --real"), "[--realtime]");
  EXPECT_EQ(completed("godobject run --rearm ''"), "[never][auto]");
  EXPECT_EQ(completed("godobject run sim/scenes/rig"), "[sim/scenes/rigid.toml]");
}

/// Checks for lines beyond 80 columns and words of the option parser.
TEST_F(CliDocuments, HelpIsReadable) {
  for_each_verb(app_, "", [&](const std::string& path, const CLI::App&) {
    const ProgramResult help = run_program(path + " --help");
    EXPECT_EQ(help.exit_code, 0) << path;
    std::istringstream lines(help.output);
    for (std::string line; std::getline(lines, line);) {
      EXPECT_TRUE(line.starts_with("Usage:") || line.size() <= 80u) << path << ": " << line;
    }
    for (const char* garbled : {"ENUM", "OR {", "->", "Excludes", "FLOAT", "INT in"})
      EXPECT_THAT(help.output, Not(HasSubstr(garbled))) << path;
  });
  const ProgramResult wrong = run_program("run sim/scenes/rigid.toml --rearm always");
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.output, HasSubstr("--rearm: always not in {never,auto}"));
}

}  // namespace
}  // namespace godobject::test::test_cli_documents
