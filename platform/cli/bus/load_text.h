// The load of a bus as text and as JSON.
#pragma once

#include <cstdio>

#include <nlohmann/json.hpp>

#include "hal/rig/bus_load.h"

namespace godobject {

/// Prints every message of the bus, by priority.
void print_bus_load(std::FILE* out, const BusLoad& load);
nlohmann::ordered_json to_json(const BusLoad& load);

}  // namespace godobject
