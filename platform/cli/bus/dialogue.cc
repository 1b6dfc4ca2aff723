#include "platform/cli/bus/dialogue.h"

#include <poll.h>

#include <cstdio>

#include "platform/cli/option_checks.h"
#include "platform/rt/clock.h"

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

}  // namespace godobject
