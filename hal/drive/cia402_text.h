// States, modes and error codes of CANopen devices in words.
#pragma once

#include <string>

#include "hal/drive/cia402_modes.h"

namespace godobject {

const char* name_of(cia402::DriveState state);
const char* name_of(cia402::OperationMode mode);

/// Meaning of the code of an emergency or of 603Fh (CiA 301 and 402, tables of error codes): its own, else
/// its class's.
const char* emergency_text(unsigned code);

/// "603Fh = 2310h, continuous over-current".
std::string error_code_text(std::int64_t error_code);

}  // namespace godobject
