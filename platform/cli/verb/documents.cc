// godobject man, godobject completion bash: documents for packagers, hidden in help.
#include <cstdio>
#include <memory>

#include "platform/cli/command_documents.h"
#include "platform/cli/verbs.h"

namespace godobject {
namespace {

ExitCode print(const std::string& text) {
  std::fputs(text.c_str(), stdout);
  return ExitCode::ok;
}

}  // namespace

void add_documents(CLI::App& app, ExitCode& code) {
  CLI::App* man = app.add_subcommand("man", "Print the manual page, in roff.")->group("");
  man->callback([&app, &code] { code = print(man_page(app, GODOBJECT_VERSION)); });

  CLI::App* completion = app.add_subcommand("completion", "Print the completion of a shell.")->group("");
  const auto shell = std::make_shared<std::string>();
  completion->add_option("SHELL", *shell, "print the completion of this shell")
      ->required()
      ->check(CLI::IsMember({"bash"}));
  completion->callback([&app, &code, shell] { code = print(bash_completion(app)); });
}

}  // namespace godobject
