#include "hal/drive/cia402_text.h"

#include "hal/base/format.h"

namespace godobject {

const char* name_of(cia402::DriveState state) {
  switch (state) {
    case cia402::DriveState::not_ready_to_switch_on: return "not ready to switch on";
    case cia402::DriveState::switch_on_disabled: return "switch on disabled";
    case cia402::DriveState::ready_to_switch_on: return "ready to switch on";
    case cia402::DriveState::switched_on: return "switched on";
    case cia402::DriveState::operation_enabled: return "operation enabled";
    case cia402::DriveState::quick_stop_active: return "quick stop active";
    case cia402::DriveState::fault_reaction_active: return "fault reaction active";
    case cia402::DriveState::fault: return "fault";
    case cia402::DriveState::unknown: break;
  }
  return "unknown state";
}

const char* emergency_text(unsigned code) {
  switch (code) {
    case 0x0000: return "no error";
    case 0x2310: return "continuous over-current";
    case 0x2320: return "short circuit or earth leakage";
    case 0x3210: return "DC link over-voltage";
    case 0x3220: return "DC link under-voltage";
    case 0x4210: return "device too hot";
    case 0x4310: return "drive too hot";
    case 0x5530: return "stored settings damaged";
    case 0x7121: return "motor blocked";
    case 0x7122: return "motor or commutation";
    case 0x7305: return "incremental encoder 1";
    case 0x7306: return "incremental encoder 2";
    case 0x7320: return "position sensor";
    case 0x8110: return "CAN overrun: frames lost";
    case 0x8120: return "CAN error passive";
    case 0x8130: return "heartbeat of another node lost";
    case 0x8140: return "recovered from bus-off";
    case 0x8150: return "identifier used twice";
    case 0x8210: return "PDO too short";
    case 0x8220: return "PDO too long";
    case 0x8240: return "SYNC of unexpected length";
    case 0x8250: return "RPDO time-out";
    case 0x8311: return "excess torque";
    case 0x8400: return "velocity controller";
    case 0x8500: return "position controller";
    case 0x8611: return "following error";
    case 0x8612: return "limit of the range reached";
    default: break;
  }
  switch (code >> 12) {
    case 0x1: return "generic error";
    case 0x2: return "current";
    case 0x3: return "voltage";
    case 0x4: return "temperature";
    case 0x5: return "hardware of the device";
    case 0x6: return "software of the device";
    case 0x7: return "additional modules";
    case 0x8: return "monitoring";
    case 0x9: return "external error";
    case 0xF: return "additional functions or manufacturer-specific";
    default: return "not in CiA 301 or 402";
  }
}

std::string error_code_text(std::int64_t error_code) {
  return format("603Fh = %04Xh, %s", static_cast<unsigned>(error_code),
                emergency_text(static_cast<unsigned>(error_code)));
}

const char* name_of(cia402::OperationMode mode) {
  switch (mode) {
    case cia402::OperationMode::none: return "none";
    case cia402::OperationMode::profile_position: return "profile position";
    case cia402::OperationMode::velocity: return "velocity";
    case cia402::OperationMode::profile_velocity: return "profile velocity";
    case cia402::OperationMode::profile_torque: return "profile torque";
    case cia402::OperationMode::homing: return "homing";
    case cia402::OperationMode::interpolated_position: return "interpolated position";
    case cia402::OperationMode::cyclic_synchronous_position: return "cyclic synchronous position";
    case cia402::OperationMode::cyclic_synchronous_velocity: return "cyclic synchronous velocity";
    case cia402::OperationMode::cyclic_synchronous_torque: return "cyclic synchronous torque";
  }
  return "manufacturer-specific";
}

}  // namespace godobject
