#include <algorithm>
#include <bit>

#include "sim/bus/can_bus.h"

namespace godobject {
namespace {

constexpr int recessive_sequence_bits = 11;
constexpr int recovery_sequences = 128;
constexpr int bits_after_acknowledge_slot =
    acknowledge_delimiter_bits + end_of_frame_bits + intermission_bits;

/// Returns the arbitration field as a number, in the order of its bits; the lower one wins. Standard: id(11)
/// RTR IDE=0. Extended: id(11) SRR=1 IDE=1 id(18) RTR.
std::uint32_t arbitration_key(const CanFrame& frame) {
  const std::uint32_t remote = frame.remote ? 1 : 0;
  if (!frame.extended) return frame.id << 21 | remote << 20;
  return (frame.id >> 18) << 21 | 0b11u << 19 | (frame.id & 0x3FFFFu) << 1 | remote;
}

bool same_on_wire(const CanFrame& a, const CanFrame& b) {
  return arbitration_key(a) == arbitration_key(b) && a.fd == b.fd && a.bit_rate_switch == b.bit_rate_switch &&
         a.size == b.size && (a.remote || std::ranges::equal(a.bytes(), b.bytes()));
}

constexpr std::uint32_t bit_of(std::size_t node) { return std::uint32_t{1} << node; }

FrameBits without_last(FrameBits bits, int count) {
  bits.nominal_rate -= count;
  return bits;
}

std::optional<Nanoseconds> earlier(std::optional<Nanoseconds> a, std::optional<Nanoseconds> b) {
  if (!a || !b) return a ? a : b;
  return std::min(*a, *b);
}

}  // namespace

SimCanWire::SimCanWire(const SimWireParams& params) noexcept : params_(params), random_(params.seed) {}

template <class Function>
void SimCanWire::for_each(NodeSet nodes, Function&& function) const {
  for (; nodes != 0; nodes &= nodes - 1) function(*nodes_[static_cast<std::size_t>(std::countr_zero(nodes))]);
}

template <class Self, class Function>
void SimCanWire::for_each_segment(Self& self, Function&& function) {
  function(self.segments_[shared_segment]);
  for (NodeSet stubs = self.stubs_; stubs != 0; stubs &= stubs - 1)
    function(self.segments_[stub_segment(static_cast<std::size_t>(std::countr_zero(stubs)))]);
}

// Nodes on the wire.

std::size_t SimCanWire::attach(SimCanPort& port) noexcept {
  const auto place = std::ranges::find(nodes_, nullptr);
  const auto node = static_cast<std::size_t>(place - nodes_.begin());
  if (node == max_nodes) return max_nodes;
  *place = &port;
  segments_[shared_segment].members |= bit_of(node);
  return node;
}

void SimCanWire::detach(std::size_t node) noexcept {
  for (Segment& segment : segments_) segment.members &= ~bit_of(node);
  nodes_[node] = nullptr;
  sending_ &= ~bit_of(node);
  timed_ &= ~bit_of(node);
}

void SimCanWire::note_queue(const SimCanPort& node) noexcept {
  if (node.index_ == max_nodes) return;
  if (node.transmit_queue_.empty()) sending_ &= ~bit_of(node.index_);
  else sending_ |= bit_of(node.index_);
}

void SimCanWire::join(std::size_t node, std::size_t segment) noexcept {
  for (Segment& other : segments_) other.members &= ~bit_of(node);
  segments_[segment].members |= bit_of(node);
  if (segment != shared_segment) stubs_ |= bit_of(node);
  if (nodes_[node]->recovery_) start_recovery(*nodes_[node]);
}

// Removes the node from the current frame. If it was the only sender, the wire becomes recessive, which
// receivers detect as a stuff error at the sixth bit.
void SimCanWire::drop_out(std::size_t node) noexcept {
  Segment& segment = segments_[segment_of(*nodes_[node])];
  const bool was_sender = (segment.senders & bit_of(node)) != 0;
  segment.senders &= ~bit_of(node);
  segment.receivers &= ~bit_of(node);
  if (segment.phase != Phase::sending || !was_sender || segment.senders != 0) return;
  for_each(segment.receivers, [](SimCanPort& receiver) {
    receiver.errors_.receive_failed();
    ++receiver.counters_.error_frames;
  });
  begin_error_frame(segment, 6 + error_flag_bits);
}

std::size_t SimCanWire::segment_of(const SimCanPort& node) const noexcept {
  return node.connected_ ? shared_segment : stub_segment(node.index_);
}

// Events.

void SimCanWire::advance_to(Nanoseconds t_ns) noexcept {
  if (t_ns < now_ns_) return;
  for (;;) {
    for_each_segment(*this, [&](Segment& segment) {
      if (segment.phase == Phase::idle) start_frame(segment);
    });
    const std::optional<Nanoseconds> t_next_ns = next_event();
    if (!t_next_ns || *t_next_ns > t_ns) break;
    now_ns_ = *t_next_ns;
    run_due_events();
  }
  now_ns_ = t_ns;
}

std::optional<Nanoseconds> SimCanWire::next_event() const noexcept {
  std::optional<Nanoseconds> t_ns;
  for_each_segment(*this, [&](const Segment& segment) { t_ns = earlier(t_ns, next_event(segment)); });
  for_each(timed_, [&](const SimCanPort& node) { t_ns = earlier(t_ns, next_event(node)); });
  return t_ns;
}

std::optional<Nanoseconds> SimCanWire::next_event(const Segment& segment) const noexcept {
  if (segment.phase != Phase::idle) return segment.t_next_ns;
  std::optional<Nanoseconds> t_ns;
  for_each(segment.members & sending_, [&](const SimCanPort& node) {
    if (!node.takes_part()) return;
    t_ns = earlier(t_ns, std::max(now_ns_, node.t_may_send_ns_));
  });
  return t_ns;
}

std::optional<Nanoseconds> SimCanWire::next_event(const SimCanPort& node) const noexcept {
  std::optional<Nanoseconds> t_ns = earlier(node.t_restart_ns_, recovery_time(node));
  if (!node.receive_queue_.empty() && node.receive_queue_.front().t_readable_ns > now_ns_) {
    t_ns = earlier(t_ns, node.receive_queue_.front().t_readable_ns);
  }
  return t_ns;
}

void SimCanWire::run_due_events() noexcept {
  for_each(timed_, [&](SimCanPort& node) {
    if (node.t_restart_ns_ && *node.t_restart_ns_ <= now_ns_) start_recovery(node);
    const std::optional<Nanoseconds> t_recovered_ns = recovery_time(node);
    if (t_recovered_ns && *t_recovered_ns <= now_ns_) finish_recovery(node);
    if (!node.t_restart_ns_ && !node.recovery_ && node.receive_queue_.empty()) timed_ &= ~bit_of(node.index_);
  });
  for_each_segment(*this, [&](Segment& segment) {
    if (segment.phase == Phase::idle || segment.t_next_ns > now_ns_) return;
    switch (segment.phase) {
      case Phase::sending: finish_sending(segment); break;
      case Phase::ending: complete_frame(segment); break;
      case Phase::intermission: become_idle(segment); break;
      case Phase::idle: break;
    }
  });
}

// A frame, from arbitration to the idle wire.

void SimCanWire::start_frame(Segment& segment) noexcept {
  NodeSet candidates = 0, listeners = 0;
  std::uint32_t winner = 0;
  for_each(segment.members & sending_, [&](const SimCanPort& node) {
    if (!node.takes_part() || node.t_may_send_ns_ > now_ns_) return;
    const std::uint32_t key = arbitration_key(node.transmit_queue_.front());
    if (candidates == 0 || key < winner) {
      candidates = bit_of(node.index_);
      winner = key;
    } else if (key == winner) {
      candidates |= bit_of(node.index_);
    }
  });
  if (candidates == 0) return;
  for_each(segment.members, [&](const SimCanPort& node) {
    if (node.takes_part()) listeners |= bit_of(node.index_);
  });

  count_idle_time(segment);
  segment.senders = candidates;
  segment.receivers = listeners & ~candidates;
  segment.frame = nodes_[static_cast<std::size_t>(std::countr_zero(candidates))]->transmit_queue_.front();
  segment.collided = false;
  for_each(candidates, [&](const SimCanPort& node) {
    if (!same_on_wire(node.transmit_queue_.front(), segment.frame)) segment.collided = true;
  });
  segment.bits = exact_bits(segment.frame);
  segment.phase = Phase::sending;
  segment.t_start_ns = now_ns_;
  segment.t_next_ns =
      now_ns_ + duration_ns(without_last(segment.bits, bits_after_acknowledge_slot), params_.rates);
}

// Called at the end of the acknowledge slot.
void SimCanWire::finish_sending(Segment& segment) noexcept {
  bool corrupted = random_.chance(params_.corruption_probability);
  for_each(segment.senders, [&](const SimCanPort& sender) {
    if (random_.chance(sender.faults_.corrupt)) corrupted = true;
  });
  if (segment.collided || corrupted || segment.receivers == 0) {
    fail_frame(segment);
    return;
  }
  segment.phase = Phase::ending;
  segment.t_next_ns =
      segment.t_start_ns + duration_ns(without_last(segment.bits, intermission_bits), params_.rates);
}

void SimCanWire::fail_frame(Segment& segment) noexcept {
  const bool flag_joined = any_error_active(segment.receivers);
  for_each(segment.senders, [&](SimCanPort& sender) {
    const bool spared = sender.errors_.is_passive() && !segment.collided && !flag_joined;
    if (!spared) sender.errors_.transmit_failed();
    ++sender.counters_.error_frames;
  });
  for_each(segment.receivers, [](SimCanPort& receiver) {
    receiver.errors_.receive_failed();
    ++receiver.counters_.error_frames;
  });
  begin_error_frame(segment, error_flag_bits + (flag_joined ? 1 : 0));
  for_each(segment.senders, [&](SimCanPort& sender) { check_bus_off(sender); });
}

void SimCanWire::begin_error_frame(Segment& segment, int bits_before_delimiter) noexcept {
  ++segment.counters.error_frames;
  segment.phase = Phase::intermission;
  segment.t_next_ns = now_ns_ + bits_ns(bits_before_delimiter + error_delimiter_bits + intermission_bits);
}

void SimCanWire::complete_frame(Segment& segment) noexcept {
  const ReceivedFrame received{.frame = segment.frame, .t_ns = now_ns_};
  for_each(segment.senders, [&](SimCanPort& sender) {
    sender.transmit_queue_.pop();
    note_queue(sender);
    sender.errors_.transmitted();
    ++sender.counters_.sent;
  });
  for_each(segment.receivers, [&](SimCanPort& receiver) {
    receiver.errors_.received();
    deliver(receiver, received);
  });
  ++segment.counters.frames;
  segment.phase = Phase::intermission;
  segment.t_next_ns = segment.t_start_ns + duration_ns(segment.bits, params_.rates);
  if (observer_.on_frame != nullptr) observer_.on_frame(observer_.context, received);
}

void SimCanWire::deliver(SimCanPort& node, const ReceivedFrame& received) noexcept {
  if (random_.chance(node.loss_probability_) || random_.chance(node.faults_.drop)) {
    ++node.lost_;
    return;
  }
  const Nanoseconds t_readable_ns = received.t_ns + node.receive_delay_ns_ + node.faults_.delay_ns;
  if (t_readable_ns > now_ns_) timed_ |= bit_of(node.index_);
  for (int copies = random_.chance(node.faults_.duplicate) ? 2 : 1; copies > 0; --copies)
    if (!node.receive_queue_.push({received, t_readable_ns})) ++node.counters_.receive_overflow;
}

// Enters idle. The acknowledge or error delimiter, end of frame and intermission end every frame with 11
// recessive bits.
void SimCanWire::become_idle(Segment& segment) noexcept {
  segment.phase = Phase::idle;
  segment.t_idle_ns = now_ns_;
  segment.counters.busy_ns += now_ns_ - segment.t_start_ns;
  for_each(segment.senders, [&](SimCanPort& sender) {
    if (sender.errors_.is_passive()) sender.t_may_send_ns_ = now_ns_ + bits_ns(suspend_transmission_bits);
  });
  segment.senders = 0;
  segment.receivers = 0;
  if (segment.members == 0 && &segment != &segments_[shared_segment])
    stubs_ &= ~bit_of(static_cast<std::size_t>(&segment - &segments_[stub_segment(0)]));
  for_each(segment.members, [&](SimCanPort& node) {
    if (!node.recovery_ || now_ns_ - node.recovery_->t_start_ns < bits_ns(recessive_sequence_bits)) return;
    if (--node.recovery_->sequences_left <= 0) finish_recovery(node);
  });
}

bool SimCanWire::any_error_active(NodeSet nodes) const noexcept {
  bool any = false;
  for_each(nodes, [&](const SimCanPort& node) { any = any || !node.errors_.is_passive(); });
  return any;
}

// Bus-off and recovery.

void SimCanWire::check_bus_off(SimCanPort& node) noexcept {
  if (!node.errors_.is_bus_off()) return;
  drop_out(node.index_);
  node.transmit_queue_.clear();
  note_queue(node);
  ++node.counters_.bus_off_events;
  if (node.restart_delay_ns_ <= 0) return;
  node.t_restart_ns_ = now_ns_ + node.restart_delay_ns_;
  timed_ |= bit_of(node.index_);
}

void SimCanWire::start_recovery(SimCanPort& node) noexcept {
  node.t_restart_ns_.reset();
  node.recovery_ = {.sequences_left = recovery_sequences, .t_start_ns = now_ns_};
  timed_ |= bit_of(node.index_);
}

// Returns the end of the recovery if the wire stays idle; nullopt while it is busy.
std::optional<Nanoseconds> SimCanWire::recovery_time(const SimCanPort& node) const noexcept {
  if (!node.recovery_) return std::nullopt;
  const Segment& segment = segments_[segment_of(node)];
  if (segment.phase != Phase::idle) return std::nullopt;
  const Nanoseconds t_counted_ns = std::max(segment.t_idle_ns, node.recovery_->t_start_ns);
  return t_counted_ns + bits_ns(node.recovery_->sequences_left * recessive_sequence_bits);
}

void SimCanWire::count_idle_time(Segment& segment) noexcept {
  for_each(segment.members, [&](SimCanPort& node) {
    if (!node.recovery_) return;
    const Nanoseconds idle_ns = now_ns_ - std::max(segment.t_idle_ns, node.recovery_->t_start_ns);
    node.recovery_->sequences_left -= static_cast<int>(idle_ns / bits_ns(recessive_sequence_bits));
  });
}

void SimCanWire::finish_recovery(SimCanPort& node) noexcept {
  node.recovery_.reset();
  node.errors_.reset();
}

}  // namespace godobject
