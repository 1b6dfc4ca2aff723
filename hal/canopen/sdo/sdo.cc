#include "hal/canopen/sdo/sdo.h"

namespace godobject::sdo {

namespace {

struct AbortText {
  std::uint32_t code;
  const char* text;
};

// CiA 301 table 22.
constexpr std::array abort_texts{
    AbortText{0x0503'0000, "toggle bit not alternated"},
    AbortText{0x0504'0000, "SDO protocol timed out"},
    AbortText{0x0504'0001, "command specifier not valid or unknown"},
    AbortText{0x0504'0002, "invalid block size"},
    AbortText{0x0504'0003, "invalid sequence number"},
    AbortText{0x0504'0004, "CRC error"},
    AbortText{0x0504'0005, "out of memory"},
    AbortText{0x0601'0000, "unsupported access to an object"},
    AbortText{0x0601'0001, "attempt to read a write-only object"},
    AbortText{0x0601'0002, "attempt to write a read-only object"},
    AbortText{0x0602'0000, "object does not exist in the object dictionary"},
    AbortText{0x0604'0041, "object cannot be mapped to the PDO"},
    AbortText{0x0604'0042, "number and length of the objects to be mapped exceed the PDO length"},
    AbortText{0x0604'0043, "general parameter incompatibility"},
    AbortText{0x0604'0047, "general internal incompatibility in the device"},
    AbortText{0x0606'0000, "access failed due to a hardware error"},
    AbortText{0x0607'0010, "data type does not match: length of service parameter does not match"},
    AbortText{0x0607'0012, "data type does not match: length of service parameter too high"},
    AbortText{0x0607'0013, "data type does not match: length of service parameter too low"},
    AbortText{0x0609'0011, "sub-index does not exist"},
    AbortText{0x0609'0030, "invalid value for the parameter (value range)"},
    AbortText{0x0609'0031, "value written too high"},
    AbortText{0x0609'0032, "value written too low"},
    AbortText{0x0609'0036, "maximum value is less than minimum value"},
    AbortText{0x060A'0023, "resource not available: SDO connection"},
    AbortText{0x0800'0000, "general error"},
    AbortText{0x0800'0020, "data cannot be transferred or stored to the application"},
    AbortText{0x0800'0021, "data cannot be transferred or stored because of local control"},
    AbortText{0x0800'0022, "data cannot be transferred or stored in the present device state"},
    AbortText{0x0800'0023, "object dictionary is not present or its generation failed"},
    AbortText{0x0800'0024, "no data available"},
};

}  // namespace

const char* text_of(AbortCode code) noexcept {
  const auto found = std::ranges::find(abort_texts, static_cast<std::uint32_t>(code), &AbortText::code);
  return found == abort_texts.end() ? "not in CiA 301: see the device's manual" : found->text;
}

}  // namespace godobject::sdo
