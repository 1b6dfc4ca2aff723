// Verbs of godobject-study that have a program or a command line of their own.
#pragma once

#include <cstdio>
#include <exception>
#include <string>

namespace godobject::study {

/// Runs run(argc, argv) without the verb, which may follow the program's name. Prints an exception after the
/// verb. Returns the exit code.
template <class F>
int run_verb(const std::string& verb, int argc, char** argv, F run) {
  const int shift = argc > 1 && argv[1] == verb ? 1 : 0;
  try {
    return run(argc - shift, argv + shift);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", verb.c_str(), error.what());
    return 1;
  }
}

}  // namespace godobject::study
