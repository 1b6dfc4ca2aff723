// One bus of this machine, for a verb that sends requests on it and waits for the answers.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>

#include <CLI/CLI.hpp>

#include "platform/cli/verbs.h"
#include "platform/linux/bus/bus.h"
#include "platform/rt/last_resort.h"

namespace godobject {

struct DialogueOptions {
  std::string bus;
  double bit_rate = 1e6;  // bit/s
  double timeout = 1;     // s, per answer

  Nanoseconds timeout_ns() const { return static_cast<Nanoseconds>(1e9 * timeout); }
};

/// Adds --bus, --bit-rate and --timeout.
void add_dialogue_options(CLI::App& verb, DialogueOptions& options);

class BusDialogue {
 public:
  /// Opens the bus to receive the frames that match a filter. On failure prints the reason to stderr and
  /// returns its exit code.
  ExitCode open(const DialogueOptions& options, std::span<const CanFilter> wanted);
  /// As above, for answers that share one COB-ID.
  ExitCode open(const DialogueOptions& options, std::uint32_t cob_id) {
    const CanFilter answers{.id = cob_id, .mask = 0x7FF};
    return open(options, {&answers, 1});
  }

  /// Runs until busy() returns false: calls on_frame for each frame, then poll, at least once per
  /// millisecond.
  void run(const std::function<bool()>& busy, const std::function<void(const CanFrame&)>& on_frame,
           const std::function<void(Nanoseconds, CanBus&)>& poll);

  /// Encodes the frames for the open bus.
  LastWords last_words(std::span<const CanFrame> frames) const;

  /// Returns the trouble of the bus after "; ", or an empty string.
  std::string trouble() const;

 private:
  std::unique_ptr<LinuxBus> bus_;
};

}  // namespace godobject
