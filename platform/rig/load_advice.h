// What is said of the load of a bus, and which is too much to run on.
#pragma once

#include <string>

#include "hal/rig/bus_load.h"

namespace godobject {

inline constexpr double advised_load_percent = 50, planned_load_percent = 70, full_load_percent = 100;

/// About the worst case: empty up to advised_load_percent.
std::string load_advice(const BusLoad& load);
/// More than the bus can carry: nothing is to run on it.
constexpr bool is_overloaded(const BusLoad& load) noexcept { return load.worst_percent > full_load_percent; }

}  // namespace godobject
