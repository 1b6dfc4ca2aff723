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

// In the order of BusError.
constexpr std::array<ErrorText, 13> error_texts{{
    {"none", ""},
    {"acknowledge",
     "nobody acknowledged a frame: is another node powered, on this cable and at this bit rate?"},
    {"bit",
     "the wire did not follow a bit that was sent: check termination (2 x 120 ohm) and for shorts; two nodes "
     "with one identifier do this too"},
    {"stuff", "six equal bits in a row: check bit rate, termination and cable length"},
    {"form", "a fixed bit of a frame was wrong: check bit rate; a classic controller on an FD bus does this"},
    {"crc", "a frame arrived damaged: check termination, shielding and cable length"},
    {"lost-arbitration", "a frame of higher priority went first: normal on a shared bus"},
    {"receive-overflow", "the controller's receive buffer overran: the machine served it too late"},
    {"transmit-overflow", "the controller's transmit buffer overran: lower the bus load"},
    {"transmit-timeout", "the driver found the controller stuck: ip link set down and up, or re-plug it"},
    {"transceiver", "the transceiver reports a short or a broken wire: check the cable"},
    {"restarted", "back from bus-off; what the others sent meanwhile is lost"},
    {"other", "an error that the driver does not specify"},
}};

const ErrorText& entry(BusError error) noexcept {
  const auto index = static_cast<std::size_t>(error);
  return error_texts[index < error_texts.size() ? index : error_texts.size() - 1];
}

}  // namespace

std::string_view name_of(BusError error) noexcept { return entry(error).name; }
std::string_view text_of(BusError error) noexcept { return entry(error).text; }

}  // namespace godobject
