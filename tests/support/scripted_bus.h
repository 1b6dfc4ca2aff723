// A bus of which a test plays the nodes: keeps the host's frames, and delivers those of the test.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "hal/can/bus.h"
#include "tests/support/may_allocate.h"

namespace godobject::test {

class ScriptedBus : public CanBus {
 public:
  bool open() noexcept override { return true; }
  void close() noexcept override { bus_state = BusState::closed; }
  SendResult try_send(const CanFrame& frame) noexcept override {
    [[maybe_unused]] const MayAllocate here;
    if (full || frame.id == refused_id) return SendResult::full;
    sent.push_back(frame);
    return SendResult::queued;
  }
  bool try_receive(ReceivedFrame& out) noexcept override {
    [[maybe_unused]] const MayAllocate here;
    if (to_receive.empty()) return false;
    out = to_receive.front();
    to_receive.pop_front();
    return true;
  }
  BusState state() const noexcept override { return bus_state; }
  BusCounters counters() const noexcept override { return {}; }
  bool is_live() const noexcept override { return live; }

  bool full = false, live = true;
  std::optional<std::uint32_t> refused_id{};  // frames with it are refused
  BusState bus_state = BusState::error_active;
  std::vector<CanFrame> sent;
  std::deque<ReceivedFrame> to_receive;
};

}  // namespace godobject::test
