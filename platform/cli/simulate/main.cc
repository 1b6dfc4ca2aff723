// godobject with simulated devices and the verb `simulate`.
#include "platform/cli/program.h"
#include "platform/simulated/session.h"

int main(int argc, char** argv) {
  return godobject::run_program(
      argc, argv, {.devices = godobject::simulated_devices(), .add_verb = godobject::add_simulate});
}
