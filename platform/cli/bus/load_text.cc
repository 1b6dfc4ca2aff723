#include "platform/cli/bus/load_text.h"

namespace godobject {

void print_bus_load(std::FILE* out, const BusLoad& load) {
  std::fprintf(out, "\n# bus %s: %.1f %% nominal, %.1f %% worst case\n", load.bus.c_str(),
               load.nominal_percent, load.worst_percent);
  std::fprintf(out, "#   %-32s %6s %10s %8s %6s\n", "message", "id", "period ms", "bits", "worst");
  for (const BusMessage& m : load.messages)
    std::fprintf(out, "#   %-32s  0x%03X %10g %8d %6d\n", m.name.c_str(), static_cast<unsigned>(m.cob_id),
                 1e3 * m.period_s, m.nominal_bits, m.worst_bits);
}

nlohmann::ordered_json to_json(const BusLoad& load) {
  nlohmann::ordered_json messages = nlohmann::ordered_json::array();
  for (const BusMessage& m : load.messages)
    messages.push_back({{"name", m.name},
                        {"cob_id", m.cob_id},
                        {"period_s", m.period_s},
                        {"nominal_bits", m.nominal_bits},
                        {"worst_bits", m.worst_bits}});
  return {{"bus", load.bus},
          {"nominal_percent", load.nominal_percent},
          {"worst_percent", load.worst_percent},
          {"messages", messages}};
}

}  // namespace godobject
