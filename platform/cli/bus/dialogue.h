// One bus of this machine, for a verb that asks something on it and waits for the answer.
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
  double timeout = 1;     // s, for each answer

  Nanoseconds timeout_ns() const { return static_cast<Nanoseconds>(1e9 * timeout); }
};

/// --bus, --bit-rate and --timeout.
void add_dialogue_options(CLI::App& verb, DialogueOptions& options);

class BusDialogue {
 public:
  /// Opens the bus; reports to stderr and returns other than ok where it cannot. wanted: what is received.
  ExitCode open(const DialogueOptions& options, std::span<const CanFilter> wanted);
  /// The same where all answers have one COB-ID.
  ExitCode open(const DialogueOptions& options, std::uint32_t cob_id) {
    const CanFilter answers{.id = cob_id, .mask = 0x7FF};
    return open(options, {&answers, 1});
  }

  /// Until busy() is false: on_frame for each frame, then poll, at least each millisecond.
  void run(const std::function<bool()>& busy, const std::function<void(const CanFrame&)>& on_frame,
           const std::function<void(Nanoseconds, CanBus&)>& poll);

  /// The frames as the open bus takes them.
  LastWords last_words(std::span<const CanFrame> frames) const;

  /// What is wrong with the bus, after "; "; empty where nothing is.
  std::string trouble() const;

 private:
  std::unique_ptr<LinuxBus> bus_;
};

}  // namespace godobject
