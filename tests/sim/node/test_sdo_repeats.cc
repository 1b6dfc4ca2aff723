// SDO over a bus that loses frames, by the fault verb drop.
#include "hal/canopen/sdo/client.h"

#include <gtest/gtest.h>

#include "tests/support/faulty_rig.h"

namespace godobject::test_sdo_repeats {
namespace {

TEST(SdoRepeats, LostFramesCostTimeAndNotTheTransfer) {
  test::FaultyRig device;
  device.play("drop bus=can0 node=1 value=0.1");
  device.cycles(1);
  CanBus& bus = *device.link.buses()[0];
  sdo::Client client(1, 30'000'000);
  int repeated = 0, failed = 0;
  for (int i = 0; i < 500; ++i) {
    ASSERT_TRUE(client.read({0x1000, 0}));
    while (client.busy()) {
      const Nanoseconds now = device.link.begin_cycle(0);
      ReceivedFrame received;
      while (bus.try_receive(received)) client.on_frame(received.frame);
      client.poll(now, bus);
    }
    repeated += client.repeats() > 0 ? 1 : 0;
    failed += client.state() == sdo::TransferState::done ? 0 : 1;
  }
  // Request or answer is lost with 0.19, all three pairs with 0.007.
  EXPECT_NEAR(repeated, 95, 30);
  EXPECT_LE(failed, 10);
}

}  // namespace
}  // namespace godobject::test_sdo_repeats
