#include "platform/rt/machine.h"

#include <sys/utsname.h>

#include <fstream>
#include <thread>

namespace godobject {
namespace {

std::string cpu_model() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (!line.starts_with("model name")) continue;
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

}  // namespace

Machine this_machine() {
  utsname names{};
  uname(&names);
  return {.cpu = cpu_model(),
          .num_cpus = std::thread::hardware_concurrency(),
          .kernel = std::string(names.release) + " " + names.version};
}

}  // namespace godobject
