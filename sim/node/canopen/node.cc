#include "sim/node/canopen/node.h"

#include <algorithm>
#include <cmath>

namespace godobject {

using canopen::NmtCommand;
using canopen::NmtState;
using canopen::ObjectAddress;
using canopen::ObjectType;

namespace {

constexpr Nanoseconds ms = 1'000'000;
constexpr std::uint16_t first_communication_object = 0x1000, last_communication_object = 0x1FFF;
constexpr ObjectAddress heartbeat_producer{0x1017, 0};

}  // namespace

SimCanopenNode::SimCanopenNode(CanBus& bus, std::uint8_t node_id, Nanoseconds heartbeat_period_ns)
    : bus_(bus),
      node_id_(node_id),
      power_up_heartbeat_ns_(heartbeat_period_ns),
      objects_(*this),
      sdo_server_(objects_),
      lss_(node_id) {
  objects_.add({0x1001, 0}, ObjectType::u8, ObjectAccess::read_only);
  objects_.add({0x1005, 0}, ObjectType::u32, ObjectAccess::read_only, canopen::sync_cob_id);
  objects_.add({0x1016, 0}, ObjectType::u8, ObjectAccess::read_only, 1);
  consumer_ = &objects_.add({0x1016, 1}, ObjectType::u32, ObjectAccess::read_write);
  objects_.add(heartbeat_producer, ObjectType::u16, ObjectAccess::read_write, heartbeat_period_ns / ms);
  identify(0, "", {});
}

void SimCanopenNode::identify(std::uint32_t device_type, std::string name, const lss::Identity& identity) {
  objects_.add({0x1000, 0}, ObjectType::u32, ObjectAccess::read_only, device_type);
  objects_.add_text({0x1008, 0}, std::move(name));
  objects_.add({0x1018, 0}, ObjectType::u8, ObjectAccess::read_only, 4);
  objects_.add({0x1018, 1}, ObjectType::u32, ObjectAccess::read_only, identity.vendor);
  objects_.add({0x1018, 2}, ObjectType::u32, ObjectAccess::read_only, identity.product);
  objects_.add({0x1018, 3}, ObjectType::u32, ObjectAccess::read_only, identity.revision);
  objects_.add({0x1018, 4}, ObjectType::u32, ObjectAccess::read_only, identity.serial);
}

void SimCanopenNode::identify_as(std::span<const ProfileObject> identity) noexcept {
  constexpr std::int64_t high_word = 0xFFFF'0000;
  for (const ProfileObject& wanted : identity) {
    Object* const object = objects_.find(wanted.address);
    if (object == nullptr) continue;
    const std::int64_t kept = wanted.address.index == 0x1000 ? object->value & high_word : 0;
    object->value = object->power_up = kept | wanted.value;
  }
}

void SimCanopenNode::add_pdo(SimPdoDefault power_up) { pdos_.emplace_back(objects_, std::move(power_up)); }

const SimPdo* SimCanopenNode::find_pdo(PdoDirection direction, int number) const noexcept {
  const auto found = std::ranges::find_if(
      pdos_, [&](const SimPdo& pdo) { return pdo.direction() == direction && pdo.number() == number; });
  return found == pdos_.end() ? nullptr : &*found;
}

// Frames.

void SimCanopenNode::poll(Nanoseconds now) noexcept {
  const Nanoseconds local_ns = local_time(now);
  for (ReceivedFrame received; bus_.try_receive(received);) on_frame(received.frame, local_ns);
  tick(local_ns);
}

void SimCanopenNode::set_clock_error(double ppm, Nanoseconds now) noexcept {
  local_origin_ns_ = local_time(now);
  origin_ns_ = now;
  clock_rate_ = 1 + 1e-6 * ppm;
}

Nanoseconds SimCanopenNode::local_time(Nanoseconds now) const noexcept {
  return local_origin_ns_ + std::llround(clock_rate_ * static_cast<double>(now - origin_ns_));
}

// Returns the bus time of a local time, rounded up: at this time local_time() has reached `local`.
Nanoseconds SimCanopenNode::bus_time(Nanoseconds local) const noexcept {
  if (local == never) return never;
  const double elapsed_ns = static_cast<double>(local - local_origin_ns_) / clock_rate_;
  return origin_ns_ + static_cast<Nanoseconds>(std::ceil(elapsed_ns)) + (clock_rate_ == 1 ? 0 : 1);
}

void SimCanopenNode::on_frame(const CanFrame& frame, Nanoseconds now) noexcept {
  if (nmt_state_ == NmtState::boot_up) return;
  now_ns_ = now;
  canopen::Nmt nmt;
  if (canopen::parse_nmt(frame, nmt) == ParseResult::ok) {
    if (nmt.node == 0 || nmt.node == node_id_) on_nmt(nmt.command, now);
    return;
  }
  if (answer_service(frame)) return;
  consume_heartbeat(frame, now);
  if (!is_operational()) return;
  std::uint8_t counter = 0;
  if (canopen::parse_sync(frame, counter) == ParseResult::ok) {
    exchange_synchronous(now);
  } else if (!receive_pdo(frame, now)) {
    on_pdo(frame, now);
  }
}

// SDO and LSS.
bool SimCanopenNode::answer_service(const CanFrame& frame) noexcept {
  lss::Message lss_request;
  if (lss::parse_frame(frame, lss::request_cob_id, lss_request) == ParseResult::ok) {
    const auto own = [this](std::uint8_t sub) {
      return static_cast<std::uint32_t>(objects_.value({0x1018, sub}));
    };
    const lss::Identity identity{.vendor = own(1), .product = own(2), .revision = own(3), .serial = own(4)};
    if (const auto answer = lss_.answer(lss_request, identity))
      send(lss::make_frame(lss::response_cob_id, *answer));
    return true;
  }
  sdo::Message request;
  if (nmt_state_ == NmtState::stopped) return false;
  if (sdo::parse_frame(frame, sdo::request_cob_id(node_id_), request) != ParseResult::ok) return false;
  if (const auto answer = sdo_server_.answer(request))
    send(sdo::make_frame(sdo::response_cob_id(node_id_), *answer));
  return true;
}

void SimCanopenNode::consume_heartbeat(const CanFrame& frame, Nanoseconds now) noexcept {
  canopen::Heartbeat heartbeat;
  const auto node = static_cast<std::uint8_t>(consumer_->value >> 16 & 0x7F);
  const Nanoseconds timeout_ns = ms * (consumer_->value & 0xFFFF);
  if (node == 0 || timeout_ns == 0) return;
  if (canopen::parse_heartbeat(frame, heartbeat) == ParseResult::ok && heartbeat.node == node)
    t_host_lost_ns_ = now + timeout_ns;
}

// PDOs.

void SimCanopenNode::exchange_synchronous(Nanoseconds now) noexcept {
  sample();
  for (SimPdo& pdo : pdos_) {
    if (pdo.direction() != PdoDirection::transmit || !pdo.on() || !pdo.synchronous()) continue;
    if (++pdo.syncs_since_sent < pdo.transmission()) continue;
    send_pdo(pdo);
  }
  for (SimPdo& pdo : pdos_) {
    if (!pdo.has_pending) continue;
    pdo.has_pending = false;
    pdo.unpack(pdo.pending);
    on_rpdo(pdo.number(), now);
  }
}

bool SimCanopenNode::receive_pdo(const CanFrame& frame, Nanoseconds now) noexcept {
  if (!canopen::is_canopen(frame)) return false;
  const auto found = std::ranges::find_if(pdos_, [&](const SimPdo& pdo) {
    return pdo.direction() == PdoDirection::receive && pdo.on() && pdo.cob_id() == frame.id;
  });
  if (found == pdos_.end()) return false;
  const ParseResult size = check_size(frame.size, found->size());
  if (size != ParseResult::ok) {
    const bool is_short = size == ParseResult::too_short;
    send(canopen::make_emergency(
        {.node = node_id_,
         .error_code = is_short ? canopen::emcy_pdo_too_short : canopen::emcy_pdo_too_long}));
    return true;
  }
  on_rpdo_received(found->number(), now);
  found->pending = frame;
  found->has_pending = found->synchronous();
  if (found->has_pending) return true;
  found->unpack(frame);
  on_rpdo(found->number(), now);
  return true;
}

void SimCanopenNode::send_pdo(SimPdo& pdo) noexcept {
  pdo.syncs_since_sent = 0;
  send(pdo.pack());
}

void SimCanopenNode::start_timer(SimPdo& pdo, Nanoseconds now) const noexcept {
  const bool runs = is_operational() && pdo.direction() == PdoDirection::transmit && pdo.on() &&
                    !pdo.synchronous() && pdo.timer_ns() > 0;
  pdo.t_timer_ns = runs ? now + pdo.timer_ns() : never;
}

// Timers.

void SimCanopenNode::tick(Nanoseconds now) noexcept {
  now_ns_ = now;
  if (nmt_state_ == NmtState::boot_up) boot(now);
  while (t_heartbeat_ns_ <= now) {
    send(canopen::make_heartbeat(node_id_, nmt_state_));
    t_heartbeat_ns_ += heartbeat_period_ns_;
  }
  if (t_host_lost_ns_ <= now) {
    t_host_lost_ns_ = never;
    on_heartbeat_lost(now);
  }
  on_tick(now);
  for (SimPdo& pdo : pdos_) {
    for (; pdo.t_timer_ns <= now; pdo.t_timer_ns += pdo.timer_ns()) {
      sample();
      send_pdo(pdo);
    }
  }
}

Nanoseconds SimCanopenNode::next_timer() const noexcept {
  Nanoseconds t_ns = std::min({t_heartbeat_ns_, t_host_lost_ns_, device_timer()});
  for (const SimPdo& pdo : pdos_) t_ns = std::min(t_ns, pdo.t_timer_ns);
  return bus_time(t_ns);
}

// Network management.

void SimCanopenNode::on_nmt(NmtCommand command, Nanoseconds now) noexcept {
  switch (command) {
    case NmtCommand::start: enter(NmtState::operational, now); break;
    case NmtCommand::stop: enter(NmtState::stopped, now); break;
    case NmtCommand::enter_pre_operational: enter(NmtState::pre_operational, now); break;
    case NmtCommand::reset_node:
      objects_.reset(last_communication_object + 1, 0xFFFF);
      on_reset();
      [[fallthrough]];
    case NmtCommand::reset_communication:
      t_heartbeat_ns_ = never;
      t_host_lost_ns_ = never;
      enter(NmtState::boot_up, now);
      break;
  }
}

void SimCanopenNode::power_cycle(Nanoseconds now) noexcept {
  lss_.power_cycle();
  on_nmt(NmtCommand::reset_node, now);
}

void SimCanopenNode::enter(NmtState state, Nanoseconds now) noexcept {
  if (state == nmt_state_) return;
  nmt_state_ = state;
  for (SimPdo& pdo : pdos_) {
    pdo.syncs_since_sent = 0;
    pdo.has_pending = false;
    start_timer(pdo, now);
  }
  on_nmt_state(now);
}

void SimCanopenNode::boot(Nanoseconds now) noexcept {
  reset_communication();
  if (bus_.try_send(canopen::make_heartbeat(node_id_, NmtState::boot_up)) != SendResult::queued) return;
  if (heartbeat_period_ns_ > 0) t_heartbeat_ns_ = now + heartbeat_period_ns_;
  enter(NmtState::pre_operational, now);
}

void SimCanopenNode::reset_communication() noexcept {
  constexpr std::uint8_t no_node_id = 255;
  if (lss_.node_id() != no_node_id) node_id_ = lss_.node_id();
  objects_.reset(first_communication_object, last_communication_object);
  for (SimPdo& pdo : pdos_) pdo.reset(node_id_);
  for (SimPdo& pdo : pdos_) pdo.t_timer_ns = never;
  sdo_server_.reset();
  heartbeat_period_ns_ = power_up_heartbeat_ns_;
  for (const SdoStep& step : stored_) write_stored(step);
}

void SimCanopenNode::store(std::vector<SdoStep> steps) {
  std::erase_if(steps, [](const SdoStep& step) {
    const bool reads = step.action == SdoAction::check || step.action == SdoAction::wait_for ||
                       step.action == SdoAction::compare || step.action == SdoAction::skip_if_same;
    return reads || step.address == heartbeat_producer;
  });
  stored_ = std::move(steps);
}

void SimCanopenNode::write_stored(const SdoStep& step) noexcept {
  const Object* object = objects_.find(step.address);
  if (object == nullptr) return;
  std::int64_t value = step.low;
  if (step.action == SdoAction::switch_off || step.action == SdoAction::switch_off_if_there)
    value = object->value | SdoSequence::pdo_invalid;
  if (step.action == SdoAction::switch_on) value = step.low | (object->value & SdoSequence::pdo_no_rtr);
  std::array<std::uint8_t, sizeof(std::uint32_t)> bytes{};
  const std::span<std::uint8_t> used = std::span(bytes).first(canopen::size_of(object->type));
  canopen::encode_number(value, used);
  static_cast<void>(objects_.write(step.address, used));
}

// Object dictionary.

sdo::AbortCode SimCanopenNode::may_write(ObjectAddress address, std::int64_t value) noexcept {
  for (const SimPdo& pdo : pdos_) {
    const sdo::AbortCode code = pdo.may_write(address, value);
    if (code != sdo::AbortCode::none) return code;
  }
  return may_write_object(address, value);
}

void SimCanopenNode::on_written(ObjectAddress address, std::int64_t value) noexcept {
  for (SimPdo& pdo : pdos_)
    if (pdo.on_written(address)) start_timer(pdo, now_ns_);
  if (address == heartbeat_producer) {
    heartbeat_period_ns_ = ms * value;
    t_heartbeat_ns_ = value > 0 ? now_ns_ + heartbeat_period_ns_ : never;
  }
  if (address.index == 0x1016) t_host_lost_ns_ = never;  // starts with the next heartbeat
  on_object_written(address, value);
}

}  // namespace godobject
