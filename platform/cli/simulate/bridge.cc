#include "platform/cli/simulate/bridge.h"

namespace godobject {

bool BusBridge::try_take(CanFrame& frame) noexcept {
  ReceivedFrame received;
  if (!bus_.try_receive(received)) return false;
  frame = received.frame;
  ++counters_.from_bus;
  return true;
}

void BusBridge::deliver(const CanFrame& frame) noexcept {
  if (port_.try_send(frame) != SendResult::queued) ++counters_.refused;
}

void BusBridge::forward(Nanoseconds now) noexcept {
  for (;;) {
    if (!waiting_) {
      ReceivedFrame received;
      if (!port_.try_receive(received)) return;
      waiting_ = received.frame;
      t_waiting_ns_ = now;
    }
    const SendResult result = bus_.try_send(*waiting_);
    if (result == SendResult::full && now - t_waiting_ns_ < patience_ns) return;
    ++(result == SendResult::queued ? counters_.to_bus : counters_.dropped);
    waiting_.reset();
  }
}

}  // namespace godobject
