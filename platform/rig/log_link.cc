#include "platform/rig/log_link.h"

#include <algorithm>
#include <fstream>

#include "hal/can/candump.h"
#include "hal/can/timing.h"
#include "hal/drive/link.h"

namespace godobject {
namespace {

constexpr std::size_t no_bus = std::numeric_limits<std::size_t>::max();

}  // namespace

LogLink::LogLink(const RigParams& rig, Nanoseconds period) : rig_(rig), period_(period) {
  for (std::size_t i = 0; i < rig.buses.size(); ++i) {
    has_canopen_ = has_canopen_ || bus_protocol(protocol_of_bus(rig_, i)).canopen;
    buses_.push_back(std::make_unique<LoggedBus>(*this, i));
    ports_.push_back(buses_.back().get());
  }
}

std::string LogLink::read(std::span<const LogSource> sources) {
  std::vector<std::string> paths;
  for (const LogSource& source : sources)
    if (std::ranges::find(paths, source.path) == paths.end()) paths.push_back(source.path);
  for (const std::string& path : paths)
    if (std::string why_not = read_file(path, sources); !why_not.empty()) return why_not;
  add_cycles_without_sync();
  end_ = std::min(end_, shut_down_);
  for (const std::unique_ptr<LoggedBus>& bus : buses_) bus->end_at(end_);
  const auto first = std::ranges::min_element(buses_, {}, [](const auto& bus) { return bus->next(); });
  if ((*first)->next() == end_of_time)
    return paths.front() + ": holds no frame of the scene's buses: give the scene of the recorded run";
  now_ = (begins_.empty() ? (*first)->next() : begins_.front()) - period_;
  for (const std::unique_ptr<LoggedBus>& bus : buses_) bus->skip_to(now_);
  return "";
}

std::string LogLink::read_file(const std::string& path, std::span<const LogSource> sources) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) return path + ": cannot be read";
  constexpr std::size_t max_log_bytes = std::size_t{512} << 20;
  if (static_cast<std::size_t>(in.tellg()) > max_log_bytes) return path + ": larger than 512 MiB";
  in.seekg(0);
  struct Entry {
    std::size_t name;
    ReceivedFrame frame;
  };
  std::vector<std::string> names;
  std::vector<Entry> entries;
  std::size_t number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    ReceivedFrame frame;
    std::string_view name;
    const CandumpResult result = parse_candump(line, frame, name);
    if (result == CandumpResult::ignored || result == CandumpResult::error_frame) continue;
    if (result != CandumpResult::ok && in.eof()) break;  // truncated when the recording program ended
    if (result != CandumpResult::ok)
      return path + ":" + std::to_string(number) +
             ": no line of a log, as candump -l or godobject run --record writes it";
    const auto known = std::ranges::find(names, name);
    entries.push_back({.name = static_cast<std::size_t>(known - names.begin()), .frame = frame});
    if (known == names.end()) names.emplace_back(name);
  }
  std::vector<std::size_t> bus_of_name(names.size(), no_bus);
  if (std::string why_not = choose(path, sources, names, bus_of_name); !why_not.empty()) return why_not;
  for (const Entry& entry : entries)
    if (bus_of_name[entry.name] != no_bus) add(bus_of_name[entry.name], entry.frame);
  return "";
}

/// Finds the interface of each bus that is in this log. Refuses a log without one of them, unless it has
/// none and none was named.
std::string LogLink::choose(const std::string& path, std::span<const LogSource> sources,
                            const std::vector<std::string>& names,
                            std::vector<std::size_t>& bus_of_name) const {
  std::string missing;
  bool is_of_scene = false;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (sources[i].path != path) continue;
    const std::string& wanted = sources[i].interface.empty() ? rig_.buses[i].name : sources[i].interface;
    auto name = std::ranges::find(names, wanted);
    const bool only_one = sources[i].interface.empty() && names.size() == 1 && rig_.buses.size() == 1;
    if (name == names.end() && only_one) name = names.begin();
    if (name == names.end()) {
      missing += (missing.empty() ? "" : ", ") + wanted;
      is_of_scene = is_of_scene || !sources[i].interface.empty();
      continue;
    }
    bus_of_name[static_cast<std::size_t>(name - names.begin())] = i;
    is_of_scene = true;
  }
  return is_of_scene && !missing.empty() ? path + ": holds no frame of " + missing : "";
}

void LogLink::add(std::size_t bus, const ReceivedFrame& frame) {
  end_ = std::max(end_, frame.t_ns);
  if (begins_cycle(bus, frame.frame)) {
    const Nanoseconds began = frame.t_ns - wire_time(bus, frame.frame);
    if (begins_.empty()) first_bus_ = bus;
    if (bus == first_bus_ && (begins_.empty() || began - begins_.back() > period_ / 2))
      begins_.push_back(began);
  } else if (!is_of_host(bus, frame.frame)) {
    buses_[bus]->add(frame);
  } else if (canopen::Nmt nmt; canopen::parse_nmt(frame.frame, nmt) == ParseResult::ok) {
    note_nmt(nmt.command, frame.t_ns);
  } else if (frame.frame.id == canopen::heartbeat_cob_id(rig_.host_node_id) && bus == first_bus_) {
    heartbeats_.push_back(frame.t_ns - wire_time(bus, frame.frame));
  }
}

/// Notes when the host that wrote the log shut the nodes down: a command to stop after a cycle, without a
/// later start.
void LogLink::note_nmt(canopen::NmtCommand command, Nanoseconds t) noexcept {
  if (command == canopen::NmtCommand::start) shut_down_ = end_of_time;
  else if (!begins_.empty()) shut_down_ = std::min(shut_down_, t);
}

/// Adds the cycles in which the host left SYNC out. Its heartbeat is then alone between two SYNCs.
void LogLink::add_cycles_without_sync() {
  for (const Nanoseconds began : heartbeats_) {
    const auto next = std::ranges::upper_bound(begins_, began);
    if (next == begins_.begin() || next == begins_.end()) continue;
    if (began - *(next - 1) > period_ / 2 && *next - began > period_ / 2) begins_.insert(next, began);
  }
}

/// True for a SYNC; where no bus of the rig has any, for a request.
bool LogLink::begins_cycle(std::size_t bus, const CanFrame& frame) const noexcept {
  const BusProtocol protocol = bus_protocol(protocol_of_bus(rig_, bus));
  if (protocol.canopen) return !frame.extended && frame.id == canopen::make_sync().id;
  return !has_canopen_ && protocol.sender(frame) == 0;
}

/// Returns the duration of a frame on the wire, ns. A log has the time of a frame's end; the start is earlier
/// by this duration.
Nanoseconds LogLink::wire_time(std::size_t bus, const CanFrame& frame) const noexcept {
  const BusParams& of = rig_.buses[bus];
  FrameBits bits = frame.fd ? nominal_bits(frame) : exact_bits(frame);
  bits.nominal_rate -= intermission_bits;
  return duration_ns(bits,
                     {.nominal = of.bit_rate, .data = of.data_bit_rate > 0 ? of.data_bit_rate : of.bit_rate});
}

/// True if the host that wrote the log sent the frame; a host does not receive its own frames.
bool LogLink::is_of_host(std::size_t bus, const CanFrame& frame) const noexcept {
  const BusProtocol protocol = bus_protocol(protocol_of_bus(rig_, bus));
  if (protocol.canopen && !frame.extended && canopen::is_from_master(frame, rig_.host_node_id)) return true;
  if (!protocol.canopen && protocol.sender(frame) == 0) return true;  // a request
  return std::ranges::any_of(rig_.drives, [&](const DriveParams& drive) {
    return drive.bus == bus && bus_protocol(drive.protocol).commanded(frame) == drive.node_id;
  });
}

Nanoseconds LogLink::begin_cycle(double /*motion_time*/) noexcept {
  while (next_begin_ < begins_.size() && begins_[next_begin_] <= began_) ++next_begin_;
  const Nanoseconds due = std::max(began_ == 0 ? now_ : began_ + period_, now_);
  const bool has_next = next_begin_ < begins_.size();
  // After the last cycle of the log, nodes may go on sending for hours.
  const bool is_silent = !has_next && !begins_.empty() && due - begins_.back() > longest_gap;
  began_ = now_ = has_next ? std::max(now_, begins_[next_begin_]) : is_silent ? std::max(due, end_) : due;
  if (now_ - due > longest_gap) skipped_ += now_ - due;
  return now_;
}

Nanoseconds LogLink::wait(Nanoseconds until) noexcept {
  Nanoseconds next = until;
  for (const std::unique_ptr<LoggedBus>& bus : buses_) next = std::min(next, std::max(bus->next(), now_));
  return now_ = std::max(now_, next);
}

SendResult LogLink::LoggedBus::try_send(const CanFrame& frame) noexcept {
  ++counters_.sent;
  if (log_.observer_.on_frame)
    log_.observer_.on_frame(log_.observer_.context, index_, {.frame = frame, .t_ns = log_.now_});
  return SendResult::queued;
}

bool LogLink::LoggedBus::try_receive(ReceivedFrame& out) noexcept {
  if (next() > log_.now_) return false;
  out = frames_[next_++];
  ++counters_.received;
  if (log_.observer_.on_frame) log_.observer_.on_frame(log_.observer_.context, index_, out);
  return true;
}

}  // namespace godobject
