// godobject for hardware alone: a build with GODOBJECT_SIM=OFF, in which nothing is simulated.
#include "platform/cli/program.h"

int main(int argc, char** argv) { return godobject::run_program(argc, argv, {}); }
