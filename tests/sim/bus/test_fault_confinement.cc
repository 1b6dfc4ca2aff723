#include "sim/bus/fault_confinement.h"

#include <gtest/gtest.h>

namespace godobject::test_fault_confinement {
namespace {

TEST(FaultConfinement, TransmitErrorsLeadThroughTheStates) {
  FaultConfinement errors;
  EXPECT_EQ(errors.state(), BusState::error_active);
  for (int i = 0; i < 11; ++i) errors.transmit_failed();
  EXPECT_EQ(errors.state(), BusState::error_active);  // 88
  errors.transmit_failed();
  EXPECT_EQ(errors.state(), BusState::error_warning);  // 96
  for (int i = 0; i < 3; ++i) errors.transmit_failed();
  EXPECT_EQ(errors.state(), BusState::error_warning);  // 120
  errors.transmit_failed();
  EXPECT_EQ(errors.state(), BusState::error_passive);  // 128
  errors.transmitted();
  EXPECT_EQ(errors.state(), BusState::error_warning);  // 127
  for (int i = 0; i < 16; ++i) errors.transmit_failed();
  EXPECT_EQ(errors.transmit_errors(), 255);
  EXPECT_EQ(errors.state(), BusState::error_passive);
  errors.transmit_failed();
  EXPECT_EQ(errors.state(), BusState::bus_off);
  errors.reset();
  EXPECT_EQ(errors.state(), BusState::error_active);
}

TEST(FaultConfinement, ReceiveErrorsMakePassiveButNeverBusOff) {
  FaultConfinement errors;
  for (int i = 0; i < 127; ++i) errors.receive_failed();
  EXPECT_EQ(errors.state(), BusState::error_warning);
  for (int i = 0; i < 1000; ++i) errors.receive_failed();
  EXPECT_EQ(errors.state(), BusState::error_passive);
  EXPECT_EQ(errors.receive_errors(), 255);
  errors.received();
  EXPECT_EQ(errors.receive_errors(), 127);
  errors.received();
  EXPECT_EQ(errors.receive_errors(), 126);
}

TEST(FaultConfinement, CountersStopAtZero) {
  FaultConfinement errors;
  errors.transmitted();
  errors.received();
  EXPECT_EQ(errors.transmit_errors(), 0);
  EXPECT_EQ(errors.receive_errors(), 0);
}

}  // namespace
}  // namespace godobject::test_fault_confinement
