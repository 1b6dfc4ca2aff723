#include "sim/fault/verb.h"

#include <algorithm>

#include "hal/base/format.h"

namespace godobject {
namespace {

constexpr std::array<FaultVerbText, num_fault_verbs> texts{{
    {.verb = FaultVerb::drop,
     .name = "drop",
     .place = FaultPlace::anywhere,
     .meaning = "its frames, sent and received, are lost",
     .value = "share of the frames",
     .default_value = 1,
     .min = 0,
     .max = 1,
     .remark = "of a drive: its watchdog stops the motor; of a tracker: a lost reply is requested again; "
               "without any its tools are `stale`, no fault"},
    {.verb = FaultVerb::duplicate,
     .name = "duplicate",
     .place = FaultPlace::bus_or_node,
     .meaning = "frames are duplicated",
     .value = "share of the frames",
     .default_value = 1,
     .min = 0,
     .max = 1,
     .remark =
         "the second copy is ignored; without bus time for both, samples are late and the pose is held"},
    {.verb = FaultVerb::delay,
     .name = "delay",
     .place = FaultPlace::anywhere,
     .meaning = "frames are received late",
     .value = "delay, s",
     .default_value = 2e-3,
     .min = 0,
     .max = 1,
     .remark = "below `stale_after`: samples are older; above a tracker's: its tools are `stale`"},
    {.verb = FaultVerb::corrupt,
     .name = "corrupt",
     .place = FaultPlace::anywhere,
     .meaning = "error frames, then repeated by the controller",
     .value = "share of the frames",
     .default_value = 0.1,
     .min = 0,
     .max = 1,
     .remark = "if most are, the sender goes bus-off and restarts at the end; of a tracker: `bad_crc`, "
               "requested again"},
    {.verb = FaultVerb::stuck,
     .name = "stuck",
     .place = FaultPlace::node,
     .meaning = "the sensor keeps its value",
     .value = {},
     .remark =
         "detected if the joint has a drive and an encoder, unless `max_slip = 0`; its end is a `spike`"},
    {.verb = FaultVerb::spike,
     .name = "spike",
     .place = FaultPlace::node,
     .meaning = "the value is displaced, for one sample or the duration",
     .value = "rad or m",
     .default_value = 1,
     .min = -1e3,
     .max = 1e3,
     .is_event = true,
     .remark = "a single sample is not used"},
    {.verb = FaultVerb::wrap,
     .name = "wrap",
     .place = FaultPlace::node,
     .meaning = "the count wraps earlier than in its calibration",
     .value = "counts",
     .default_value = 256,
     .min = 2,
     .max = 4294967296.0,
     .remark = "a jump of its count"},
    {.verb = FaultVerb::nan,
     .name = "nan",
     .place = FaultPlace::node,
     .meaning = "no value: NaN in floats, 8000 0000h in integers",
     .value = {},
     .remark = "its samples are not used"},
    {.verb = FaultVerb::reboot_node,
     .name = "reboot-node",
     .place = FaultPlace::node,
     .meaning = "it loses power for the duration, then boots",
     .value = {},
     .is_event = true,
     .remark = "then pre-operational until the faults are cleared"},
    {.verb = FaultVerb::emcy,
     .name = "emcy",
     .place = FaultPlace::node,
     .meaning = "it reports an error; a drive enters Fault",
     .value = "emergency error code",
     .default_value = 0x1000,
     .min = 1,
     .max = 0xFFFF,
     .is_event = true,
     .remark = ""},
    {.verb = FaultVerb::bus_off,
     .name = "bus-off",
     .place = FaultPlace::bus_or_node,
     .meaning = "controller goes bus-off, restarts at the end",
     .value = {},
     .is_event = true,
     .remark = "of the host: `bus_down`, in process only; on a real bus its nodes become silent"},
    {.verb = FaultVerb::restart,
     .name = "restart",
     .place = FaultPlace::bus_or_node,
     .meaning = "controller starts to recover from bus-off: 128 times 11 recessive bits",
     .value = {},
     .is_event = true,
     .remark = "faults stay until they are cleared"},
    {.verb = FaultVerb::unplug,
     .name = "unplug",
     .place = FaultPlace::anywhere,
     .meaning = "disconnected, connected again at the end",
     .value = {},
     .remark = "a tracker is initialised again"},
    {.verb = FaultVerb::id_collision,
     .name = "id-collision",
     .place = FaultPlace::node,
     .meaning = "a second encoder with its id and another count joins",
     .value = {},
     .remark = "both answer SYNC at once and go bus-off"},
    {.verb = FaultVerb::clock_drift,
     .name = "clock-drift",
     .place = FaultPlace::node,
     .meaning = "its clock is fast",
     .value = "ppm",
     .default_value = 1e4,
     .min = -9e5,
     .max = 9e6,
     .remark = "samples follow SYNC; only a heartbeat can be late"},
    {.verb = FaultVerb::swap_ids,
     .name = "swap-ids",
     .place = FaultPlace::node,
     .meaning = "this encoder and another of its bus exchange node ids",
     .value = "node id of the other",
     .default_value = 2,
     .min = 1,
     .max = 127,
     .remark = "joints and drives differ, or a jump; not detected without a drive at equal coordinates"},
    {.verb = FaultVerb::second_host,
     .name = "second-host",
     .place = FaultPlace::bus,
     .meaning = "another host joins: SYNC and heartbeat each period; commands if drives are no CANopen nodes",
     .value = "period, s",
     .default_value = 0.01,
     .min = 1e-3,
     .max = 1,
     .remark = "detected by its frames with the host's identifiers"},
    {.verb = FaultVerb::flood,
     .name = "flood",
     .place = FaultPlace::bus,
     .meaning = "frames of no node that win against all others",
     .value = "frames per s",
     .default_value = 2000,
     .min = 1,
     .max = 2e4,
     .remark = "7000 fill 1 Mbit/s"},
    {.verb = FaultVerb::press,
     .name = "press",
     .place = FaultPlace::node,
     .meaning = "its button is pressed, and released at the end",
     .value = "input of the button",
     .default_value = 1,
     .min = 1,
     .max = 8,
     .remark = "after an emergency stop armed again on request only"},
    {.verb = FaultVerb::missing,
     .name = "missing",
     .place = FaultPlace::tracker,
     .meaning = "a tool is hidden",
     .value = "number of the tool",
     .default_value = 1,
     .min = 1,
     .max = 8,
     .remark = "limit `held`; the tool is `missing`, no fault"},
    {.verb = FaultVerb::disabled,
     .name = "disabled",
     .place = FaultPlace::tracker,
     .meaning = "a wired tool is unplugged",
     .value = "number of the tool",
     .default_value = 1,
     .min = 1,
     .max = 8,
     .remark = "limit `held`; the tool is `disabled`, no fault"},
}};

std::string_view place_text(FaultPlace place) {
  constexpr std::array<std::string_view, 5> texts_of_places{"node", "bus", "node or bus",
                                                            "node, bus or tracker", "tracker"};
  return texts_of_places[static_cast<std::size_t>(place)];
}

/// Returns the text in brackets: target, `value` with its default, and `once` of an event.
std::string kind_text(const FaultVerbText& text) {
  std::string out(place_text(text.place));
  if (!text.value.empty()) out += "; " + std::string(text.value) + ", " + shortest(text.default_value);
  return text.is_event ? out + "; once" : out;
}

}  // namespace

std::span<const FaultVerbText, num_fault_verbs> fault_verb_texts() noexcept { return texts; }

const FaultVerbText& text_of(FaultVerb verb) noexcept { return texts[static_cast<std::size_t>(verb)]; }

std::optional<FaultVerb> fault_verb_named(std::string_view name) noexcept {
  const auto text = std::ranges::find(texts, name, &FaultVerbText::name);
  if (text == texts.end()) return std::nullopt;
  return text->verb;
}

std::string fault_reference_markdown() {
  std::string out;
  for (const FaultVerbText& text : texts)
    out += "- `" + std::string(text.name) + "` (" + kind_text(text) + "): " + std::string(text.meaning) +
           (text.remark.empty() ? "" : "; " + std::string(text.remark)) + "\n";
  return out;
}

}  // namespace godobject
