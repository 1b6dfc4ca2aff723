// Command line of `godobject-study z-width`.
#pragma once

namespace godobject::study {

/// Runs the command. argv begins with the program, or with the verb after it. Returns the exit code.
int run_wall_command(int argc, char** argv);

}  // namespace godobject::study
