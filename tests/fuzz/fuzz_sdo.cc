// The clients of SDO and LSS against servers with random answers, at any time.
#include "hal/canopen/lss.h"
#include "hal/canopen/sdo/client.h"
#include "tests/fuzz/decode.h"
#include "tests/fuzz/taking_bus.h"

namespace {

using namespace godobject;

void begin(fuzz::Input& in, sdo::Client& client) {
  const canopen::ObjectAddress address{static_cast<std::uint16_t>(in.word()), in.byte()};
  if ((in.byte() & 1) != 0) {
    static_cast<void>(client.read(address));
  } else {
    static_cast<void>(client.write(address, in.bytes(in.byte() % 40)));
  }
}

/// Returns mostly answers that the client waits for: the right ids, eight bytes.
CanFrame answer(fuzz::Input& in) {
  CanFrame frame{.id = in.byte() % 4 == 0 ? lss::response_cob_id : sdo::response_cob_id(5), .size = 8};
  std::ranges::copy(in.bytes(8), frame.data.begin());
  return frame;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  fuzz::TakingBus bus;
  sdo::Client client(5);
  lss::Master master;
  const fuzz::NoAllocation guard;
  for (Nanoseconds now = 0; !in.empty(); now += 100'000'000) {
    const std::uint8_t what = in.byte();
    if ((what & 1) != 0) begin(in, client);
    if ((what & 2) != 0) static_cast<void>(master.set_node_id(in.byte()));
    if ((what & 4) != 0) static_cast<void>(master.select({.vendor = in.word()}));
    bus.takes = (what & 8) == 0;
    const CanFrame frame = (what & 16) != 0 ? fuzz::frame_of(in) : answer(in);
    client.on_frame(frame);
    master.on_frame(frame);
    client.poll(now, bus);
    master.poll(now, bus);
    if (client.data().size() > sdo::Client::capacity) std::abort();
  }
  return 0;
}
