// godobject without simulation: main() of a build with GODOBJECT_SIM=OFF.
#include "platform/cli/program.h"

int main(int argc, char** argv) { return godobject::run_program(argc, argv, {}); }
