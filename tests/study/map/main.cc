// godobject-stability-map: the verb stability-map of godobject-study alone, for the nodes of a cluster. It
// takes a tenth of the time to build.
#include "tests/study/map/command.h"

int main(int argc, char** argv) { return godobject::study::run_map_command(argc, argv); }
