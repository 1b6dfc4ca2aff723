#include "platform/rig/load_advice.h"

#include <array>
#include <cstdio>

namespace godobject {

std::string load_advice(const BusLoad& load) {
  const char* verdict = nullptr;
  if (is_overloaded(load)) {
    verdict = "error: the bus cannot carry its messages; raise bit_rate, raise step, or use more buses";
  } else if (load.worst_percent > planned_load_percent) {
    verdict = "warning: above 70 %, messages of low priority may come a period late; use more buses";
  } else if (load.worst_percent > advised_load_percent) {
    verdict = "warning: above 50 %, little is left for repeated and sporadic messages";
  }
  if (!verdict) return "";
  std::array<char, 32> percent{};
  std::snprintf(percent.data(), percent.size(), "%.1f", load.worst_percent);
  return "bus " + load.bus + ": worst-case load " + percent.data() + " %: " + verdict;
}

}  // namespace godobject
