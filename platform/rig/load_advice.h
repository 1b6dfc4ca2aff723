// Advice on the load of a bus, and the limit above which no run starts.
#pragma once

#include <string>

#include "hal/rig/bus_load.h"

namespace godobject {

inline constexpr double advised_load_percent = 50, planned_load_percent = 70, full_load_percent = 100;

/// Returns the advice on the worst-case load; empty up to advised_load_percent.
std::string load_advice(const BusLoad& load);
/// True if the load exceeds the capacity of the bus; no run may start on it.
constexpr bool is_overloaded(const BusLoad& load) noexcept { return load.worst_percent > full_load_percent; }

}  // namespace godobject
