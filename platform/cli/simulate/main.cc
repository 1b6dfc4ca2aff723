// godobject: with simulated devices and the verb `simulate`, unless GODOBJECT_SIM is off.
#include "platform/cli/program.h"
#ifdef GODOBJECT_HAS_SIM
#include "platform/simulated/session.h"
#endif

int main(int argc, char** argv) {
#ifdef GODOBJECT_HAS_SIM
  return godobject::run_program(
      argc, argv, {.simulated = godobject::simulated_devices(), .add_verb = godobject::add_simulate});
#else
  return godobject::run_program(argc, argv, {});
#endif
}
