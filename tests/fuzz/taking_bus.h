// A bus that accepts or refuses frames, and delivers frames, as the input determines.
#pragma once

#include "hal/can/bus.h"
#include "tests/fuzz/decode.h"

namespace godobject::fuzz {

class TakingBus final : public CanBus {
 public:
  bool open() noexcept override { return true; }
  void close() noexcept override {}
  SendResult try_send(const CanFrame&) noexcept override {
    return takes ? SendResult::queued : SendResult::full;
  }
  bool try_receive(ReceivedFrame& out) noexcept override {
    if (left == 0) return false;
    --left;
    out = {.frame = frame_of(*in), .t_ns = now + static_cast<std::int16_t>(in->word()) * Nanoseconds{1000}};
    return true;
  }
  BusState state() const noexcept override { return BusState::error_active; }
  BusCounters counters() const noexcept override { return {}; }

  bool takes = true;
  Input* in = nullptr;
  Nanoseconds now = 0;
  int left = 0;  // frames to deliver
};

}  // namespace godobject::fuzz
