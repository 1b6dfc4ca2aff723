// Object dictionary of a simulated CiA 402 drive, and its PDOs after power-up.
#pragma once

#include <vector>

#include "hal/rig/params.h"
#include "sim/node/canopen/node.h"

namespace godobject {

// Default unit of 6076h, mN m. Torques 6071h and 6077h are in per mille of 6076h.
inline constexpr double torque_rated_unit_Nm = 1e-3;

inline constexpr canopen::ObjectAddress error_code_object{0x603F, 0}, controlword_object{0x6040, 0},
    statusword_object{0x6041, 0}, abort_connection_option{0x6007, 0}, mode_object{0x6060, 0},
    mode_display_object{0x6061, 0}, position_object{0x6064, 0}, velocity_object{0x606C, 0},
    target_torque_object{0x6071, 0}, torque_object{0x6077, 0}, supported_modes_object{0x6502, 0},
    target_position_object{0x607A, 0}, home_offset_object{0x607C, 0}, homing_method_object{0x6098, 0},
    target_velocity_object{0x60FF, 0}, quick_stop_option_object{0x605A, 0};

/// 1018h of simulated drives. CiA has not assigned this vendor id.
inline constexpr lss::Identity sim_drive_identity{
    .vendor = 0x0000'0DEB, .product = 0x402, .revision = 0x0001'0000, .serial = 1};

/// 6007h, i16: reaction of a drive to a lost heartbeat of the host (CiA 402-2).
enum class AbortConnection : std::int16_t { no_action = 0, fault = 1, disable_voltage = 2, quick_stop = 3 };

/// Adds the objects of a drive. supported_modes: 6502h; mode n is bit n - 1. unit_Nm: unit of 6076h, N m.
void add_drive_objects(ObjectDictionary& objects, const DriveParams& params, SimDefaults defaults,
                       std::uint32_t supported_modes, double unit_Nm = torque_rated_unit_Nm);

/// Returns the PDOs. deadline_ms: of RPDO1. event_ms: of TPDO2. Both apply to SimDefaults::rig.
std::vector<SimPdoDefault> drive_pdos(SimDefaults defaults, std::uint8_t status_every_nth_sync,
                                      std::uint16_t deadline_ms, std::uint16_t event_ms);

}  // namespace godobject
