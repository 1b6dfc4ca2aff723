// Polhemus records from random bytes: every accepted pose is valid, and is written the same again.
#include <cmath>
#include <cstdlib>

#include "hal/tracker/polhemus.h"
#include "tests/fuzz/decode.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace godobject;
  const fuzz::NoAllocation guard;
  polhemus::RecordReceiver receiver;
  for (std::size_t i = 0; i < size; ++i) {
    if (receiver.push(data[i]) != polhemus::RecordReceiver::Event::record) continue;
    const polhemus::Record& record = receiver.record();
    if (!record.X_TH.p.allFinite() || !(std::abs(record.X_TH.q.norm() - 1) < 1e-6)) std::abort();
    std::array<std::uint8_t, polhemus::max_record_size> wire;
    if (polhemus::make_record(record, wire).empty()) std::abort();
  }
  return 0;
}
