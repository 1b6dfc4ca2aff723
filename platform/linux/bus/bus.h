// A CAN bus of this machine: a thread can wait on it, and an address on the command line makes it.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/nonblocking.h"
#include "hal/can/bus.h"
#include "hal/can/filter.h"
#include "platform/rt/setup.h"
#include "platform/rt/signals.h"

namespace godobject {

/// Time stamps of received frames are CLOCK_MONOTONIC, as MonotonicClock::now(). Counters are kept when a bus
/// is closed and opened again.
class LinuxBus : public CanBus {
 public:
  /// Readable when try_receive may have a new frame; -1 while closed. For ppoll.
  virtual int descriptor() const noexcept GODOBJECT_NONBLOCKING = 0;
  /// Returns the reason of a failed open() or the meaning of a state() other than error_active, and the
  /// remedy. Empty if there is no trouble. Allocates: not for the loop.
  virtual std::string trouble() const = 0;
  /// Reports every frame to the observer from within try_receive: received frames, and own ones once they are
  /// seen complete. Frames come in the order of the wire, with their time on it. Returns false if this bus
  /// does not see its own frames; it then reports none.
  [[nodiscard]] virtual bool observe(const FrameObserver&) noexcept { return false; }
  /// Name for other programs: interface, path of a terminal (of `pty:` once it is open) or of a log.
  /// Allocates.
  virtual std::string name() const { return {}; }
  /// Returns the bytes that send a frame by one write to descriptor(), for the last resort
  /// (platform/rt/signals.h). Empty if the bus cannot carry the frame. Allocates.
  virtual std::string as_written(const CanFrame&) const { return {}; }
  /// Returns one line on reads and writes that the kernel delayed, with the remedy; empty if there were none.
  /// Allocates.
  virtual std::string slowness() const { return {}; }
  /// Rest of a line that a write to descriptor() cut off; null if this bus has no lines. Lives as long as the
  /// bus.
  virtual const LineRest* line_rest() const noexcept { return nullptr; }
};

struct BusSettings {
  double bit_rate = 1e6;                 // bit/s, as expected by the scene
  double data_bit_rate = 0;              // bit/s, CAN FD; 0: classic
  std::span<const CanFilter> filters{};  // empty: all frames
};

/// A bus to be checked before it is opened.
struct BusCheck {
  std::string name;     // of the bus, in the scene
  std::string where{};  // interface, path of a terminal, or of a log
  BusSettings settings{};
  std::size_t frames = 0;            // number of frames that the host sends at once
  std::filesystem::path root = "/";  // folder of /dev and /sys
};

/// A kind of bus, by the name that --bus uses.
struct BusBackend {
  std::string_view name;   // "slcan"
  std::string_view where;  // text after the colon, with an example; empty: none
  std::unique_ptr<LinuxBus> (*make)(const std::string& where, const BusSettings& settings) = nullptr;
  std::vector<RtStep> (*check)(const BusCheck& bus) = nullptr;  // null: nothing exists before it is opened
  std::size_t max_where = std::string::npos;                    // characters
  const char* no_answers = nullptr;                             // reason why nodes do not answer on it
  const char* no_device = nullptr;  // reason why a device cannot be simulated on it
  bool makes_terminal = false;      // true if its terminal's name is printed once it is open
  bool comes_back = false;          // after it was down
  bool is_file = false;
};

struct BusAddress {
  const BusBackend* backend = nullptr;
  std::string where;  // interface, path of a terminal, or of a log
};

/// Parses `text`. None with the error and the valid forms in `error`.
std::optional<BusAddress> parse_bus_address(std::string_view text, std::string& error);

/// Makes a closed bus. Allocates; the bus itself does not.
std::unique_ptr<LinuxBus> make_bus(const BusAddress& address, const BusSettings& settings);

/// Option value with a name: "can0=socketcan:vcan0", "polaris=/dev/ttyUSB0".
struct NamedAddress {
  std::string name;  // empty: an address alone
  std::string address;
};

/// Splits NAME=ADDRESS. of_addresses: a character that occurs in addresses and not in names; a '=' after it
/// belongs to the address.
inline NamedAddress split_name(const std::string& text, char of_addresses) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || text.find(of_addresses) < equals) return {.name = "", .address = text};
  return {.name = text.substr(0, equals), .address = text.substr(equals + 1)};
}

/// Returns "'can0', 'can1'", for messages.
template <class Named>
std::string quoted_names(const Named& all) {
  std::string names;
  for (const auto& one : all) names += (names.empty() ? "'" : ", '") + one.name + "'";
  return names;
}

// ---- a candump log as a bus: frames arrive at the recorded intervals ----------------------------------

/// "FILE" or "FILE,INTERFACE", as in the addresses of buses. The name of a file may contain a comma.
struct LogAddress {
  std::string path;
  std::string interface;  // empty: not given
};
LogAddress parse_log_address(const std::string& where);

/// Replays a log. Its first frame, of any interface, arrives when open() is called. Sent frames are counted
/// as sent and discarded. After the last frame the bus is `down`, with "end of the log" in trouble().
class ReplayBus final : public LinuxBus {
 public:
  /// where: path of a log, optionally a comma and the interface; a log of one interface needs none.
  ReplayBus(const std::string& where, const BusSettings& settings);
  ~ReplayBus() override { close(); }

  /// Reads and checks the whole log. Returns false with the wrong line in trouble().
  bool open() noexcept override;
  void close() noexcept override;
  SendResult try_send(const CanFrame& frame) noexcept override;
  bool try_receive(ReceivedFrame& out) noexcept override;
  BusState state() const noexcept override { return state_; }
  BusCounters counters() const noexcept override { return counters_; }

  /// A timer that expires when the next frame is due.
  int descriptor() const noexcept override { return timer_fd_; }
  std::string trouble() const override;
  std::string name() const override { return path_; }

 private:
  bool fail(std::string why);
  bool check_log();
  bool take_next() noexcept;
  void arm() noexcept;

  std::string path_, interface_;
  std::vector<CanFilter> filters_;
  std::string log_{};         // text, parsed line by line during the replay because it is the smallest form
  std::size_t position_ = 0;  // position in log_ of the next line to be parsed
  ReceivedFrame next_{};      // next frame; its time is on CLOCK_MONOTONIC
  bool has_next_ = false;
  bool is_cut_ = false;       // true if the last line is cut off
  Nanoseconds begin_ns_ = 0;  // time of the log's first frame
  Nanoseconds shift_ = 0;     // offset from the log's time to CLOCK_MONOTONIC
  int timer_fd_ = -1;
  BusState state_ = BusState::closed;
  BusCounters counters_{};
  std::string why_{};
};

}  // namespace godobject
