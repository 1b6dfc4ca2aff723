// Parameters of a bus.
#pragma once

#include <string>

namespace godobject {

struct BusParams {
  std::string name;          // "can0"
  double bit_rate = 1e6;     // bit/s, arbitration phase
  double data_bit_rate = 0;  // bit/s, data phase of CAN FD; 0: a classic bus
};

}  // namespace godobject
