#include "hal/can/bus.h"

namespace godobject {

std::string_view name_of(BusState state) noexcept {
  constexpr std::array<std::string_view, 7> names{"closed",  "error-active", "error-warning", "error-passive",
                                                  "bus-off", "down",         "gone"};
  const auto index = static_cast<std::size_t>(state);
  return index < names.size() ? names[index] : "?";  // cppcheck-suppress returnDanglingLifetime
}

namespace {

struct ErrorText {
  std::string_view name, text;
};

// Name and remedy of each error, in the order of BusError.
constexpr std::array<ErrorText, 13> error_texts{{
    {"none", ""},
    {"acknowledge",
     "no node acknowledged a frame: check that another node is powered, on this cable and at this bit rate"},
    {"bit",
     "a bit was read back inverted: check termination (2 x 120 ohm), short circuits, and for two nodes with "
     "one identifier"},
    {"stuff", "six consecutive equal bits: check bit rate, termination and cable length"},
    {"form", "a fixed bit of a frame was wrong: check bit rate, and for a classic controller on an FD bus"},
    {"crc", "a frame arrived damaged: check termination, shielding and cable length"},
    {"lost-arbitration", "a frame of higher priority went first: normal on a shared bus"},
    {"receive-overflow",
     "the controller's receive buffer overran: lower the load of the machine, which reads it too late"},
    {"transmit-overflow", "the controller's transmit buffer overran: lower the bus load"},
    {"transmit-timeout",
     "the driver reports a stuck controller: set the interface down and up (ip link), or re-plug the "
     "adapter"},
    {"transceiver", "the transceiver reports a short or a broken wire: check the cable"},
    {"restarted", "recovered from bus-off; frames received meanwhile are lost"},
    {"other", "an error not specified by the driver"},
}};

const ErrorText& entry(BusError error) noexcept {
  const auto index = static_cast<std::size_t>(error);
  return error_texts[index < error_texts.size() ? index : error_texts.size() - 1];
}

}  // namespace

std::string_view name_of(BusError error) noexcept { return entry(error).name; }
std::string_view text_of(BusError error) noexcept { return entry(error).text; }

}  // namespace godobject
