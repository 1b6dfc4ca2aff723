// Texts of states, modes and error codes of CANopen devices.
#pragma once

#include <string>

#include "hal/drive/cia402_modes.h"

namespace godobject {

const char* name_of(cia402::DriveState state);
const char* name_of(cia402::OperationMode mode);

/// Returns the meaning of the code of an emergency or of 603Fh (CiA 301 and 402): that of the code, otherwise
/// that of its class.
const char* emergency_text(unsigned code);

/// Returns "603Fh = 2310h, continuous over-current".
std::string error_code_text(std::int64_t error_code);

}  // namespace godobject
