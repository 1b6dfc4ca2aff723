// Decoders of all CANopen messages of the rig, with any frame.
#include "hal/canopen/cia406.h"
#include "hal/drive/cia402.h"
#include "tests/fuzz/decode.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace godobject;
  fuzz::Input in(data, size);
  const auto node = static_cast<std::uint8_t>(in.byte() & 0x7F);
  const CanFrame frame = fuzz::frame_of(in);
  const fuzz::NoAllocation guard;
  canopen::Nmt nmt;
  canopen::Heartbeat heartbeat;
  canopen::Emergency emergency;
  cia402::Command command;
  cia402::Status status;
  cia402::Event event;
  std::uint32_t position = 0;
  std::uint8_t counter = 0;
  static_cast<void>(canopen::parse_nmt(frame, nmt));
  static_cast<void>(canopen::parse_heartbeat(frame, heartbeat));
  static_cast<void>(canopen::parse_emergency(frame, emergency));
  static_cast<void>(canopen::parse_sync(frame, counter));
  static_cast<void>(cia402::parse_command(frame, node, command));
  static_cast<void>(cia402::parse_status(frame, node, status));
  static_cast<void>(cia402::parse_event(frame, node, event));
  static_cast<void>(cia406::parse_position(frame, node, position));
  static_cast<void>(cia402::decode_state(status.statusword));
  return 0;
}
