#include "platform/cli/bus/dialogue.h"

#include <poll.h>

#include <cstdio>

#include "hal/canopen/sdo/sequence.h"
#include "platform/cli/command_line.h"
#include "platform/rig/buses.h"
#include "platform/rt/cyclic.h"

namespace godobject {

void add_dialogue_options(CLI::App& verb, DialogueOptions& options) {
  verb.add_option("--bus", options.bus,
                  "use this bus: socketcan:IFACE, slcan:PATH or pty:; see docs/buses.md")
      ->required();
  verb.add_option("--bit-rate", options.bit_rate, "set the bit rate of the bus, bit/s")
      ->check(number_above(0, 1e6))
      ->capture_default_str();
  verb.add_option("--timeout", options.timeout, "wait for each answer up to this time, s")
      ->check(number_above(0, 600))
      ->capture_default_str();
}

ExitCode BusDialogue::open(const DialogueOptions& options, std::span<const CanFilter> wanted) {
  std::string error;
  const std::optional<BusAddress> address = parse_bus_address(options.bus, error);
  if (address && address->backend->no_answers != nullptr) error = address->backend->no_answers;
  if (!error.empty()) {
    std::fprintf(stderr, "--bus: %s\n", error.c_str());
    return ExitCode::usage;
  }
  bus_ = make_bus(*address, {.bit_rate = options.bit_rate, .filters = wanted});
  if (!bus_->open()) {
    std::fprintf(stderr, "--bus %s: %s\n", options.bus.c_str(), bus_->trouble().c_str());
    return ExitCode::not_available;
  }
  if (address->backend->makes_terminal) std::fprintf(stderr, "%s\n", bus_->trouble().c_str());
  return ExitCode::ok;
}

void BusDialogue::run(const std::function<bool()>& busy, const std::function<void(const CanFrame&)>& on_frame,
                      const std::function<void(Nanoseconds, CanBus&)>& poll) {
  constexpr timespec longest_wait{.tv_sec = 0, .tv_nsec = 1'000'000};
  while (busy()) {
    ReceivedFrame received;
    while (bus_->try_receive(received)) on_frame(received.frame);
    poll(MonotonicClock().now(), *bus_);
    if (!busy()) break;
    pollfd waiting{.fd = bus_->descriptor(), .events = POLLIN, .revents = 0};
    ppoll(&waiting, 1, &longest_wait, nullptr);
  }
  poll(MonotonicClock().now(), *bus_);  // sends an abort if one is pending
}

LastWords BusDialogue::last_words(std::span<const CanFrame> frames) const {
  LastWords words{.descriptor = bus_->descriptor(), .writes = {}, .rest = bus_->line_rest()};
  for (const CanFrame& frame : frames) words.writes.push_back(bus_->as_written(frame));
  return words;
}

std::string BusDialogue::trouble() const {
  const std::string text = bus_->trouble();
  return text.empty() ? "" : "; " + text;
}

void add_node_options(CLI::App& verb, NodeOptions& options) {
  add_dialogue_options(verb, options.dialogue);
  verb.add_option("--node", options.node, "address this node-ID")->required()->check(CLI::Range(1, 127));
  verb.add_option("--host-node", options.host_node, "watch for the heartbeat of a host with this node-ID")
      ->check(CLI::Range(1, 127))
      ->capture_default_str();
}

ExitCode NodeDialogue::open() {
  constexpr std::uint32_t exactly = 0x7FF;
  const auto host = static_cast<std::uint8_t>(options_.host_node);
  const std::array wanted{
      CanFilter{.id = sdo::response_cob_id(options_.node_id()), .mask = exactly},
      CanFilter{.id = canopen::sync_cob_id, .mask = exactly},
      CanFilter{.id = canopen::heartbeat_cob_id(host), .mask = exactly},
  };
  const ExitCode code = bus_.open(options_.dialogue, wanted);
  constexpr Nanoseconds listening_ns = 500'000'000;  // several heartbeats of any host
  if (code == ExitCode::ok) wait(listening_ns);
  return code;
}

std::optional<std::int64_t> NodeDialogue::read(const TypedObject& object) {
  if (!client_.read(object.address) || !transfer(object.address, " read")) return std::nullopt;
  const std::size_t size = canopen::size_of(object.type);
  const std::span<const std::uint8_t> data = client_.data(size);
  if (data.size() == size) return canopen::decode_number(data, canopen::is_signed(object.type));
  failure_ = to_string(object.address) + " has " + std::to_string(client_.data().size()) +
             " bytes, not the " + std::to_string(size) + " of the standard: is this the right device?";
  return std::nullopt;
}

std::optional<std::string> NodeDialogue::read_text(canopen::ObjectAddress address) {
  if (!client_.read(address) || !transfer(address, " read")) return std::nullopt;
  std::string text;
  for (const std::uint8_t c : client_.data()) text += c >= 0x20 && c < 0x7F ? static_cast<char>(c) : '?';
  return text;
}

bool NodeDialogue::write(const TypedObject& object, std::int64_t value) {
  std::array<std::uint8_t, 4> bytes{};
  const auto used = std::span(bytes).first(canopen::size_of(object.type));
  canopen::encode_number(value, used);
  return client_.write(object.address, used) && transfer(object.address, " <- " + std::to_string(value));
}

LastWords NodeDialogue::last_words(const TypedObject& object, std::int64_t value) const {
  std::array<std::uint8_t, 4> bytes{};
  const auto used = std::span(bytes).first(canopen::size_of(object.type));
  canopen::encode_number(value, used);
  sdo::Client client = options_.make_client();
  FrameNotebook notes;
  if (client.write(object.address, used)) client.poll(0, notes);
  return bus_.last_words(notes.frames());
}

bool NodeDialogue::was_absent() const {
  return client_.state() == sdo::TransferState::aborted &&
         (client_.abort_code() == sdo::AbortCode::no_object ||
          client_.abort_code() == sdo::AbortCode::no_sub_index);
}

ExitCode NodeDialogue::report() const {
  std::fprintf(stderr, "node %d: %s\n", options_.node, failure_.c_str());
  return ExitCode::fault;
}

void NodeDialogue::command(canopen::NmtCommand command) {
  to_send_ = canopen::make_nmt(command, options_.node_id());
  constexpr Nanoseconds to_take_effect_ns = 10'000'000;
  wait(to_take_effect_ns);
}

void NodeDialogue::wait(Nanoseconds duration) {
  const Nanoseconds t_end_ns = MonotonicClock().now() + duration;
  bus_.run([&] { return MonotonicClock().now() < t_end_ns; },
           [this](const CanFrame& frame) { on_frame(frame); },
           [this](Nanoseconds now, CanBus& bus) { poll(now, bus); });
}

bool NodeDialogue::transfer(canopen::ObjectAddress address, const std::string& what) {
  bus_.run([this] { return client_.busy(); }, [this](const CanFrame& frame) { on_frame(frame); },
           [this](Nanoseconds now, CanBus& bus) { poll(now, bus); });
  failure_.clear();
  if (client_.state() == sdo::TransferState::done) return true;
  failure_ = to_string(address) + what + ": " + client_.failure_text() + bus_.trouble();
  return false;
}

void NodeDialogue::on_frame(const CanFrame& frame) {
  if (client_.on_frame(frame)) return;
  std::uint8_t counter = 0;
  canopen::Heartbeat heartbeat;
  if (canopen::parse_sync(frame, counter) == ParseResult::ok) host_seen_ = "SYNC";
  else if (canopen::parse_heartbeat(frame, heartbeat) == ParseResult::ok &&
           heartbeat.node == options_.host_node && host_seen_.empty())
    host_seen_ = "the heartbeat of node " + std::to_string(heartbeat.node);
}

void NodeDialogue::poll(Nanoseconds now, CanBus& bus) {
  constexpr Nanoseconds period_ns = 100'000'000;
  if (to_send_ && bus.try_send(*to_send_) == SendResult::queued) to_send_.reset();
  client_.poll(now, bus);
  if (!heartbeats_ || now < t_heartbeat_ns_) return;
  const auto host = static_cast<std::uint8_t>(options_.host_node);
  const CanFrame heartbeat = canopen::make_heartbeat(host, canopen::NmtState::operational);
  if (bus.try_send(heartbeat) == SendResult::queued) t_heartbeat_ns_ = now + period_ns;
}

}  // namespace godobject
