// A CAN bus of this machine: one that a thread can wait on, made from an address on the command line.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "hal/can/bus.h"
#include "hal/can/filter.h"
#include "platform/rt/last_resort.h"

namespace godobject {

/// The time stamps of received frames are CLOCK_MONOTONIC, as MonotonicClock::now(). Counters stay when a bus is
/// closed and opened again.
class LinuxBus : public CanBus {
 public:
  /// Readable when try_receive may have something new; -1 while closed. For ppoll.
  virtual int descriptor() const noexcept = 0;
  /// Why open() failed or what state() other than error_active means here, and what to do about it; empty:
  /// nothing is wrong. Allocates: not for the loop.
  virtual std::string trouble() const = 0;
  /// From now on every frame that comes by, with its time on the wire and in the order of the wire, from within
  /// try_receive: those received, and own ones once they are seen complete. False: this bus does not see its
  /// own frames, and shows nothing.
  [[nodiscard]] virtual bool observe(const FrameObserver&) noexcept { return false; }
  /// Where other programs find it: the interface, the path of a terminal (of `pty:` once it is open), of a
  /// log. Allocates.
  virtual std::string name() const { return {}; }
  /// The bytes that hand a frame to descriptor() in one write, for when nothing else of the program works any more
  /// (platform/rt/last_resort.h). Empty: it carries no such frame. Allocates.
  virtual std::string as_written(const CanFrame&) const { return {}; }
  /// Reads and writes that the kernel kept, and what to do, as one line; empty: none. Allocates.
  virtual std::string slowness() const { return {}; }
  /// The rest of a line that a write to descriptor() has cut off; null: this bus has no lines. Lives as long
  /// as the bus.
  virtual const LineRest* line_rest() const noexcept { return nullptr; }
};

struct BusSettings {
  double bit_rate = 1e6;                 // bit/s; what the scene expects of the bus
  double data_bit_rate = 0;              // bit/s, CAN FD; 0: classic
  std::span<const CanFilter> filters{};  // empty: everything
};

/// A kind of bus, as --bus names it.
struct BusBackend {
  std::string_view name;   // "slcan"
  std::string_view where;  // what stands after the colon, with an example; empty: nothing
  std::unique_ptr<LinuxBus> (*make)(const std::string& where, const BusSettings& settings) = nullptr;
  std::size_t max_where = std::string::npos;  // characters
  const char* no_answers = nullptr;           // why nodes cannot be asked over it
  const char* no_device = nullptr;            // why a device cannot be played on it
  bool makes_terminal = false;                // it says the name of its terminal once it is open
  bool comes_back = false;                    // after it was down
  bool is_file = false;
};

struct BusAddress {
  const BusBackend* backend = nullptr;
  std::string where;  // interface, path of a terminal, or of a log
};

/// None: `error` says what is wrong with `text` and what it may be.
std::optional<BusAddress> parse_bus_address(std::string_view text, std::string& error);

/// Closed. Allocates; the bus does not later.
std::unique_ptr<LinuxBus> make_bus(const BusAddress& address, const BusSettings& settings);

}  // namespace godobject
