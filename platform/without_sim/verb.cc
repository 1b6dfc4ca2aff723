// The verb `simulate` in a build without simulated devices (GODOBJECT_SIM=OFF): there is none.
#include "platform/cli/verbs.h"

namespace godobject {

void add_simulate(CLI::App&, ExitCode&) {}

}  // namespace godobject
