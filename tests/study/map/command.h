// Command line of the stability map.
#pragma once

namespace godobject::study {

/// Runs `PROGRAM stability-map ...`; argv begins with the verb. Returns the exit status: 0, 1 for an error, 2
/// for misuse.
int run_map_command(int argc, char** argv);

}  // namespace godobject::study
