#include "hal/can/transmit_slots.h"

#include <algorithm>
#include <span>

namespace godobject {

bool PacedCanBus::add_slot(std::uint32_t id, Nanoseconds lifetime) noexcept {
  if (num_slots_ == max_slots || slot_of({.id = id}) != nullptr) return false;
  slots_[num_slots_++] = {.id = id, .lifetime = lifetime, .occupied = false, .waiting = {}};
  return true;
}

void PacedCanBus::advance_to(Nanoseconds now) noexcept {
  now_ = now;
  offer_waiting();
}

void PacedCanBus::close() noexcept {
  abandon();
  bus_.close();
}

SendResult PacedCanBus::try_send(const CanFrame& frame) noexcept {
  const SendResult result = send(frame);
  if (result != SendResult::queued) ++refused_;
  return result;
}

bool PacedCanBus::try_receive(ReceivedFrame& out) noexcept {
  offer_waiting();
  return bus_.try_receive(out);
}

BusCounters PacedCanBus::counters() const noexcept {
  BusCounters counters = bus_.counters();
  counters.send_refused = refused_;
  counters.send_dropped += transmit_.dropped();
  return counters;
}

SendResult PacedCanBus::send(const CanFrame& frame) noexcept {
  if (is_cut_off(bus_.state())) abandon();
  if (waiting() == 0) {
    const SendResult result = bus_.try_send(frame);
    return result == SendResult::full && store(frame) ? SendResult::queued : result;
  }
  if (!is_valid(frame)) return SendResult::invalid;
  // The frame is stored before waiting frames are offered. Otherwise an older command with this identifier
  // may be sent first.
  const bool stored = store(frame);
  offer_waiting();
  if (stored) return SendResult::queued;
  return store(frame) ? SendResult::queued : SendResult::full;
}

PacedCanBus::Slot* PacedCanBus::slot_of(const CanFrame& frame) noexcept {
  if (frame.extended) return nullptr;
  const auto used = std::span(slots_).first(num_slots_);
  const auto slot = std::ranges::find(used, frame.id, &Slot::id);
  return slot == used.end() ? nullptr : &*slot;
}

bool PacedCanBus::store(const CanFrame& frame) noexcept {
  Slot* const slot = slot_of(frame);
  if (slot == nullptr) return queue_.push({.frame = frame, .t_expiry = now_ + queue_lifetime_});
  if (slot->occupied) ++transmit_.replaced;
  else ++waiting_in_slots_;
  slot->occupied = true;
  slot->waiting = {.frame = frame, .t_expiry = now_ + slot->lifetime};
  return true;
}

/// Offers waiting frames to the bus, up to the first that it does not accept.
void PacedCanBus::offer_waiting() noexcept {
  if (waiting() == 0) return;
  if (is_cut_off(bus_.state())) return abandon();
  while (!queue_.empty()) {
    if (offer(queue_.front()) == Offer::stays) return;
    queue_.pop();
  }
  for (Slot& slot : std::span(slots_).first(num_slots_)) {
    if (!slot.occupied) continue;
    if (offer(slot.waiting) == Offer::stays) return;
    slot.occupied = false;
    --waiting_in_slots_;
  }
}

PacedCanBus::Offer PacedCanBus::offer(const Waiting& waiting) noexcept {
  if (now_ > waiting.t_expiry) {
    ++transmit_.expired;
    return Offer::gone;
  }
  const SendResult result = bus_.try_send(waiting.frame);
  if (result == SendResult::full) return Offer::stays;
  ++(result == SendResult::queued ? transmit_.retried : transmit_.abandoned);
  return Offer::gone;
}

/// Drops all waiting frames: they are stale by the time the bus is back.
void PacedCanBus::abandon() noexcept {
  transmit_.abandoned += waiting();
  queue_.clear();
  for (Slot& slot : slots_) slot.occupied = false;
  waiting_in_slots_ = 0;
}

}  // namespace godobject
