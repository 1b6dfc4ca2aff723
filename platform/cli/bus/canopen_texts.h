// States, modes and error codes of CANopen devices in words.
#pragma once

#include "hal/drive/cia402_modes.h"

namespace godobject {

const char* name_of(cia402::DriveState state);
const char* name_of(cia402::OperationMode mode);

/// What the code of an emergency or of 603Fh means (CiA 301 and 402, tables of error codes): itself, else its class.
const char* emergency_text(unsigned code);

}  // namespace godobject
