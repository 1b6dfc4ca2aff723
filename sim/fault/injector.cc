#include "sim/fault/injector.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace godobject {
namespace {

constexpr Nanoseconds impostor_heartbeat_ns = 100'000'000;
constexpr double max_power_on_counts = 500'000;
constexpr double impostor_counts = 12345;  // no working node shows this value for long

bool acts_on(const SimFault& fault, std::size_t bus, std::uint8_t node_id) noexcept {
  return fault.node_id == node_id && fault.first_bus <= bus && bus < fault.end_bus;
}

}  // namespace

void FaultInjector::add_bus(SimCanWire& wire, SimCanPort& host, std::vector<SimNode*>& nodes,
                            const RigParams& rig) {
  buses_.push_back({.host = &host,
                    .nodes = &nodes,
                    .impostor_port = std::make_unique<SimCanPort>(wire),
                    .second_host = {wire, frames_of_second_host(rig, buses_.size())},
                    .flood = {wire, {flooding_frame}}});
}

std::size_t FaultInjector::add_node(std::size_t bus, SimCanPort& port, SimNode& node,
                                    const Calibration& calibration) {
  auto impostor = std::make_unique<SimEncoder>(*buses_[bus].impostor_port, node.node_id(), Calibration{},
                                               impostor_heartbeat_ns);
  impostor->set_position(impostor_counts);
  nodes_.push_back({.bus = bus,
                    .port = &port,
                    .node = &node,
                    .impostor = std::move(impostor),
                    .calibration = calibration,
                    .shows = nodes_.size(),
                    .power_on = draw_power_on(calibration)});
  return nodes_.size() - 1;
}

void FaultInjector::schedule_all(std::span<const SimFault> faults) {
  waiting_.assign(faults.begin(), faults.end());
  waiting_.reserve(faults.size() + capacity);
  active_.reserve(faults.size() + capacity);
  for (const BusEntry& bus : buses_) bus.nodes->reserve(bus.nodes->size() + 3);
}

bool FaultInjector::schedule(const SimFault& fault) noexcept {
  if (waiting_.size() + active_.size() >= active_.capacity() || waiting_.size() == waiting_.capacity())
    return false;
  waiting_.push_back(fault);
  return true;
}

void FaultInjector::run(Nanoseconds now, double motion_time) noexcept {
  const auto ended = [&](const ActiveFault& active) {
    const bool is_due = active.t_end_ns && *active.t_end_ns <= now;
    if (is_due) end(active.fault);
    return is_due;
  };
  bool changed = std::erase_if(active_, ended) > 0;
  const auto begins = [&](const SimFault& fault) {
    const bool is_due = fault.at <= motion_time;
    if (is_due) begin(fault, now);
    return is_due;
  };
  changed = std::erase_if(waiting_, begins) > 0 || changed;
  if (changed) apply(now);
}

void FaultInjector::clear(Nanoseconds now) noexcept {
  waiting_.clear();
  for (const ActiveFault& active : active_) end(active.fault);
  active_.clear();
  apply(now);
}

double FaultInjector::shown(std::size_t node) const noexcept {
  const NodeEntry& from = nodes_[nodes_[node].shows];
  const double q = from.sensor.shown(from.q, from.calibration);
  if (&from == &nodes_[node] || std::isnan(q)) return q;
  // counts of the other sensor, interpreted by this one's calibration
  const Calibration& by = nodes_[node].calibration;
  const double counts = counts_at(q, from.calibration);
  return by.home + by.sign * (counts - static_cast<double>(by.offset_counts)) / by.counts_per_unit;
}

// Performs the actions at the beginning of a fault; apply() does the continuous ones.
void FaultInjector::begin(const SimFault& fault, Nanoseconds now) noexcept {
  ++begun_;
  const bool once = text_of(fault.verb).is_event && !fault.duration_ns;
  NodeEntry* const node = node_of(fault);
  switch (fault.verb) {
    case FaultVerb::reboot_node:
      node->node->power_cycle(now);
      node->power_on = draw_power_on(node->calibration);
      if (!once) node->port->close();  // the boot-up message is sent once the port is open
      break;
    case FaultVerb::emcy: node->node->trip(static_cast<std::uint16_t>(fault.value)); break;
    case FaultVerb::bus_off: for_each_port(fault, [](SimCanPort& port) { port.force_bus_off(); }); break;
    case FaultVerb::restart:
      for_each_port(fault, [](SimCanPort& port) { static_cast<void>(port.restart()); });
      break;
    case FaultVerb::id_collision: admit_impostor(fault, now); break;
    case FaultVerb::second_host: admit(&BusEntry::second_host, fault, fault.value, now); break;
    case FaultVerb::flood: admit(&BusEntry::flood, fault, 1 / fault.value, now); break;
    default: break;
  }
  if (once && fault.verb != FaultVerb::spike) return;
  active_.push_back({.fault = fault, .t_begin_ns = now, .t_end_ns = std::nullopt});
  if (once) active_.back().t_end_ns = now;  // ends in the next run: affects one SYNC
  else if (fault.duration_ns) active_.back().t_end_ns = now + *fault.duration_ns;
}

void FaultInjector::end(const SimFault& fault) noexcept {
  switch (fault.verb) {
    case FaultVerb::reboot_node: static_cast<void>(node_of(fault)->port->open()); break;
    case FaultVerb::bus_off:
    case FaultVerb::corrupt:  // most senders are bus-off by then
      for_each_port(fault, [](SimCanPort& port) { static_cast<void>(port.restart()); });
      break;
    case FaultVerb::id_collision:
      dismiss_impostor(buses_[fault.first_bus]);
      static_cast<void>(node_of(fault)->port->restart());
      break;
    case FaultVerb::second_host: dismiss(&BusEntry::second_host, fault); break;
    case FaultVerb::flood: dismiss(&BusEntry::flood, fault); break;
    default: break;
  }
}

/// Returns whole counts from -max_power_on_counts on, as a coordinate; 0 for an absolute sensor.
double FaultInjector::draw_power_on(const Calibration& calibration) noexcept {
  if (!calibration.incremental) return 0;
  return std::floor(max_power_on_counts * (2 * random_.uniform() - 1)) / calibration.counts_per_unit;
}

const SimCanPort* FaultInjector::port_of(std::size_t bus, std::uint8_t node_id) const noexcept {
  const std::size_t index = index_of(bus, node_id);
  return index < nodes_.size() ? nodes_[index].port : nullptr;
}

void FaultInjector::apply(Nanoseconds now) noexcept {
  for (std::size_t bus = 0; bus < buses_.size(); ++bus) apply(*buses_[bus].host, bus, 0);
  for (NodeEntry& n : nodes_) {
    const std::uint8_t id = n.node->node_id();
    apply(*n.port, n.bus, id);
    const std::optional<double> held = n.sensor.held;
    n.sensor = {.offset = level(FaultVerb::spike, n.bus, id).value_or(0),
                .wraps_at_counts = level(FaultVerb::wrap, n.bus, id).value_or(0),
                .no_value = level(FaultVerb::nan, n.bus, id).has_value()};
    if (level(FaultVerb::stuck, n.bus, id)) n.sensor.held = held.value_or(n.q);
    const double clock_error_ppm = level(FaultVerb::clock_drift, n.bus, id).value_or(0);
    if (clock_error_ppm != n.clock_error_ppm) n.node->set_clock_error(clock_error_ppm, now);
    n.clock_error_ppm = clock_error_ppm;
  }
  swap_ids();
}

void FaultInjector::swap_ids() noexcept {
  for (std::size_t i = 0; i < nodes_.size(); ++i) nodes_[i].shows = i;
  for (const ActiveFault& active : active_) {
    if (active.fault.verb != FaultVerb::swap_ids) continue;
    const std::size_t bus = active.fault.first_bus;
    const std::size_t one = index_of(bus, active.fault.node_id);
    const std::size_t other = index_of(bus, static_cast<std::uint8_t>(active.fault.value));
    if (one < nodes_.size() && other < nodes_.size()) std::swap(nodes_[one].shows, nodes_[other].shows);
  }
}

void FaultInjector::apply(SimCanPort& port, std::size_t bus, std::uint8_t node_id) const noexcept {
  const auto value = [&](FaultVerb verb) { return level(verb, bus, node_id).value_or(0); };
  port.set_faults({.drop = value(FaultVerb::drop),
                   .duplicate = value(FaultVerb::duplicate),
                   .corrupt = value(FaultVerb::corrupt),
                   .delay_ns = static_cast<Nanoseconds>(1e9 * value(FaultVerb::delay))});
  port.set_connected(!level(FaultVerb::unplug, bus, node_id));
}

/// Returns the value of the latest active fault of this verb there; nullopt if none.
std::optional<double> FaultInjector::level(FaultVerb verb, std::size_t bus,
                                           std::uint8_t node_id) const noexcept {
  std::optional<double> value;
  for (const ActiveFault& active : active_)
    if (active.fault.verb == verb && acts_on(active.fault, bus, node_id)) value = active.fault.value;
  return value;
}

// Adds an impostor to the bus of the fault, replacing an earlier one. It is operational at once and answers
// SYNC.
void FaultInjector::admit_impostor(const SimFault& fault, Nanoseconds now) noexcept {
  BusEntry& bus = buses_[fault.first_bus];
  dismiss_impostor(bus);
  if (!bus.impostor_port->open()) return;
  bus.impostor = node_of(fault)->impostor.get();
  bus.impostor->power_cycle(now);
  bus.impostor->tick(now);
  bus.impostor->on_frame(canopen::make_nmt(canopen::NmtCommand::start, fault.node_id), now);
  bus.nodes->push_back(bus.impostor);
}

void FaultInjector::dismiss_impostor(BusEntry& bus) noexcept {
  if (bus.impostor == nullptr) return;
  std::erase(*bus.nodes, bus.impostor);
  bus.impostor = nullptr;
  bus.impostor_port->close();
}

/// Adds a stranger to the buses of the fault. period_s: between its frames.
void FaultInjector::admit(Stranger BusEntry::*which, const SimFault& fault, double period_s,
                          Nanoseconds now) noexcept {
  dismiss(which, fault);
  for (std::size_t i = fault.first_bus; i < fault.end_bus; ++i) {
    const Stranger& stranger = buses_[i].*which;
    if (!stranger.port->open()) continue;
    stranger.node->set_period(to_ns(period_s));
    stranger.node->power_cycle(now);
    buses_[i].nodes->push_back(stranger.node.get());
  }
}

void FaultInjector::dismiss(Stranger BusEntry::*which, const SimFault& fault) noexcept {
  for (std::size_t i = fault.first_bus; i < fault.end_bus; ++i) {
    const Stranger& stranger = buses_[i].*which;
    std::erase(*buses_[i].nodes, stranger.node.get());
    stranger.port->close();
  }
}

FaultInjector::NodeEntry* FaultInjector::node_of(const SimFault& fault) noexcept {
  const auto node = std::ranges::find_if(
      nodes_, [&](const NodeEntry& n) { return acts_on(fault, n.bus, n.node->node_id()); });
  return node == nodes_.end() ? nullptr : &*node;
}

std::size_t FaultInjector::index_of(std::size_t bus, std::uint8_t node_id) const noexcept {
  const auto node = std::ranges::find_if(
      nodes_, [&](const NodeEntry& n) { return n.bus == bus && n.node->node_id() == node_id; });
  return static_cast<std::size_t>(node - nodes_.begin());
}

template <class Function>
void FaultInjector::for_each_port(const SimFault& fault, Function&& function) noexcept {
  if (NodeEntry* const node = node_of(fault)) return function(*node->port);
  for (std::size_t bus = fault.first_bus; bus < fault.end_bus; ++bus) function(*buses_[bus].host);
}

}  // namespace godobject
