#include "sim/bus/can_bus.h"

namespace godobject {

SimCanPort::SimCanPort(SimCanWire& wire) noexcept : wire_(wire), index_(wire.attach(*this)) {}

SimCanPort::~SimCanPort() {
  close();
  if (index_ < SimCanWire::max_nodes) wire_.detach(index_);
}

bool SimCanPort::open() noexcept {
  open_ = index_ < SimCanWire::max_nodes;
  return open_;
}

void SimCanPort::close() noexcept {
  if (!open_) return;
  open_ = false;
  wire_.drop_out(index_);
  transmit_queue_.clear();
  wire_.note_queue(*this);
  receive_queue_.clear();
  errors_.reset();
  t_restart_ns_.reset();
  recovery_.reset();
}

SendResult SimCanPort::try_send(const CanFrame& frame) noexcept {
  const auto answer = [&] {
    if (!is_valid(frame)) return SendResult::invalid;
    if (!open_) return SendResult::down;
    if (errors_.is_bus_off()) return SendResult::off;
    return queue(frame);
  };
  const SendResult result = answer();
  if (result != SendResult::queued) ++counters_.send_refused;
  return result;
}

SendResult SimCanPort::queue(const CanFrame& frame) noexcept {
  if (wire_.random_.chance(faults_.drop)) {
    ++lost_;
    return SendResult::queued;  // the sender is not informed
  }
  if (replace(frame)) return SendResult::queued;
  if (!transmit_queue_.push(frame)) return SendResult::full;
  wire_.note_queue(*this);
  if (wire_.random_.chance(faults_.duplicate)) static_cast<void>(transmit_queue_.push(frame));
  return SendResult::queued;
}

bool SimCanPort::replace(const CanFrame& frame) noexcept {
  constexpr std::uint32_t first_pdo = 0x180, end_pdo = 0x580;
  if (!has_pdo_buffers_ || frame.extended || frame.id < first_pdo || frame.id >= end_pdo) return false;
  const auto& segment = wire_.segments_[wire_.segment_of(*this)];
  const bool front_is_leaving =
      segment.phase != SimCanWire::Phase::idle && (segment.senders >> index_ & 1u) != 0;
  for (std::size_t i = front_is_leaving ? 1 : 0; i < transmit_queue_.size(); ++i) {
    CanFrame& waiting = transmit_queue_[i];
    if (waiting.extended || waiting.id != frame.id) continue;
    waiting = frame;
    return true;
  }
  return false;
}

bool SimCanPort::try_receive(ReceivedFrame& out) noexcept {
  if (receive_queue_.empty() || receive_queue_.front().t_readable_ns > wire_.now()) return false;
  out = receive_queue_.front().received;
  receive_queue_.pop();
  ++counters_.received;
  return true;
}

BusState SimCanPort::state() const noexcept { return open_ ? errors_.state() : BusState::closed; }

BusCounters SimCanPort::counters() const noexcept {
  BusCounters counters = counters_;
  counters.transmit_error_counter = errors_.transmit_errors();
  counters.receive_error_counter = errors_.receive_errors();
  return counters;
}

bool SimCanPort::restart() noexcept {
  if (!open_ || !errors_.is_bus_off()) return false;
  if (!recovery_) wire_.start_recovery(*this);
  return true;
}

void SimCanPort::force_bus_off() noexcept {
  if (!takes_part()) return;
  errors_.give_up();
  wire_.check_bus_off(*this);
}

void SimCanPort::set_connected(bool connected) noexcept {
  if (connected == connected_ || index_ == SimCanWire::max_nodes) return;
  wire_.drop_out(index_);
  connected_ = connected;
  wire_.join(index_, connected ? SimCanWire::shared_segment : SimCanWire::stub_segment(index_));
}

}  // namespace godobject
