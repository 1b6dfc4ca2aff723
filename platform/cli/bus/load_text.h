// What the load of a bus is shown as, and what is said of it.
#pragma once

#include <cstdio>
#include <string>

#include <nlohmann/json.hpp>

#include "hal/rig/bus_load.h"

namespace godobject {

inline constexpr double advised_load_percent = 50, planned_load_percent = 70, full_load_percent = 100;

/// Every message of the bus, by priority.
void print_bus_load(std::FILE* out, const BusLoad& load);
/// About the worst case: empty up to advised_load_percent.
std::string load_advice(const BusLoad& load);
nlohmann::ordered_json to_json(const BusLoad& load);

}  // namespace godobject
