// Processor and kernel of this machine, for reports.
#pragma once

#include <string>

namespace godobject {

struct Machine {
  std::string cpu;  // model name
  unsigned num_cpus = 0;
  std::string kernel;  // release and version
};

Machine this_machine();

}  // namespace godobject
