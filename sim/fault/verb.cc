#include "sim/fault/verb.h"

#include <algorithm>

#include "hal/base/format.h"

namespace godobject {
namespace {

constexpr std::array<FaultVerbText, num_fault_verbs> texts{{
    {.verb = FaultVerb::drop,
     .name = "drop",
     .place = FaultPlace::anywhere,
     .meaning = "frames that it sends or should receive are lost",
     .value = "share of the frames",
     .default_value = 1,
     .min = 0,
     .max = 1,
     .remark = "of a drive: its own watchdog stops the motor. Of a tracker: a lost reply is requested again; "
               "if all are lost, its tools are `stale`, which is no fault"},
    {.verb = FaultVerb::duplicate,
     .name = "duplicate",
     .place = FaultPlace::bus_or_node,
     .meaning = "frames are duplicated",
     .value = "share of the frames",
     .default_value = 1,
     .min = 0,
     .max = 1,
     .remark = "the second copy is ignored; both take bus time: if a cycle has no room for them, samples are "
               "late and the pose is held"},
    {.verb = FaultVerb::delay,
     .name = "delay",
     .place = FaultPlace::anywhere,
     .meaning = "received frames can be read only after a delay",
     .value = "delay, s",
     .default_value = 2e-3,
     .min = 0,
     .max = 1,
     .remark = "below `stale_after`: the samples are older by the delay. Of a tracker: above its "
               "`stale_after` its tools are `stale`"},
    {.verb = FaultVerb::corrupt,
     .name = "corrupt",
     .place = FaultPlace::anywhere,
     .meaning = "frames are destroyed on the wire: error frame, then repeated by the controller",
     .value = "share of the frames",
     .default_value = 0.1,
     .min = 0,
     .max = 1,
     .remark = "a few raise bus load and error counters. If most are corrupted, the sender goes bus-off and "
               "restarts at the end of the duration. Of a tracker: `bad_crc`, then requested again"},
    {.verb = FaultVerb::stuck,
     .name = "stuck",
     .place = FaultPlace::node,
     .meaning = "the sensor keeps its present value",
     .value = {},
     .remark = "detected if the joint has a drive and an encoder, and not with `max_slip = 0`; otherwise it "
               "is indistinguishable from a joint at rest, and the jump at its end is a `spike`"},
    {.verb = FaultVerb::spike,
     .name = "spike",
     .place = FaultPlace::node,
     .meaning = "the sensor value is displaced, for one sample or for the duration",
     .value = "rad or m",
     .default_value = 1,
     .min = -1e3,
     .max = 1e3,
     .is_event = true,
     .remark = "a single sample is not used: the step holds the last one"},
    {.verb = FaultVerb::wrap,
     .name = "wrap",
     .place = FaultPlace::node,
     .meaning = "the sensor's count wraps at fewer counts than in its calibration",
     .value = "counts",
     .default_value = 256,
     .min = 2,
     .max = 4294967296.0,
     .remark = "appears as a jump of its count"},
    {.verb = FaultVerb::nan,
     .name = "nan",
     .place = FaultPlace::node,
     .meaning = "the sensor has no value: NaN in floats, 8000 0000h in integers on the wire",
     .value = {},
     .remark = "its samples are not used"},
    {.verb = FaultVerb::reboot_node,
     .name = "reboot-node",
     .place = FaultPlace::node,
     .meaning = "the node loses power for the duration, then boots",
     .value = {},
     .is_event = true,
     .remark = "it is then pre-operational until the faults are cleared"},
    {.verb = FaultVerb::emcy,
     .name = "emcy",
     .place = FaultPlace::node,
     .meaning = "the node reports an error; a drive also enters its state Fault",
     .value = "emergency error code",
     .default_value = 0x1000,
     .min = 1,
     .max = 0xFFFF,
     .is_event = true,
     .remark = ""},
    {.verb = FaultVerb::bus_off,
     .name = "bus-off",
     .place = FaultPlace::bus_or_node,
     .meaning = "the controller goes bus-off; at the end of the duration it restarts",
     .value = {},
     .is_event = true,
     .remark = "of the host: `bus_down`, in process only; on a real bus the host has another controller, and "
               "its nodes become silent"},
    {.verb = FaultVerb::restart,
     .name = "restart",
     .place = FaultPlace::bus_or_node,
     .meaning = "the controller starts to recover from bus-off: 128 times 11 recessive bits",
     .value = {},
     .is_event = true,
     .remark = "faults stay set until they are cleared"},
    {.verb = FaultVerb::unplug,
     .name = "unplug",
     .place = FaultPlace::anywhere,
     .meaning = "the plug is disconnected, and connected at the end of the duration",
     .value = {},
     .remark = "a reconnected tracker is initialised again"},
    {.verb = FaultVerb::id_collision,
     .name = "id-collision",
     .place = FaultPlace::node,
     .meaning = "a second encoder with the node's id and another count joins the bus",
     .value = {},
     .remark = "both answer SYNC at once and go bus-off"},
    {.verb = FaultVerb::clock_drift,
     .name = "clock-drift",
     .place = FaultPlace::node,
     .meaning = "the node's clock is fast",
     .value = "ppm",
     .default_value = 1e4,
     .min = -9e5,
     .max = 9e6,
     .remark = "samples follow SYNC; only a heartbeat can be late"},
    {.verb = FaultVerb::swap_ids,
     .name = "swap-ids",
     .place = FaultPlace::node,
     .meaning = "this encoder and another one on its bus exchange their node ids",
     .value = "node id of the other",
     .default_value = 2,
     .min = 1,
     .max = 127,
     .remark = "detected as a difference of joints and drives, or as a jump. Not detected for joints without "
               "a drive at equal coordinates"},
    {.verb = FaultVerb::second_host,
     .name = "second-host",
     .place = FaultPlace::bus,
     .meaning = "another host joins the bus: SYNC and a heartbeat once per period; if the drives are no "
                "CANopen nodes, commands",
     .value = "period, s",
     .default_value = 0.01,
     .min = 1e-3,
     .max = 1,
     .remark = "a host does not receive its own frames, but those of another host with the same identifiers"},
    {.verb = FaultVerb::missing,
     .name = "missing",
     .place = FaultPlace::tracker,
     .meaning = "a tool is hidden from its tracker",
     .value = "number of the tool",
     .default_value = 1,
     .min = 1,
     .max = 8,
     .remark = "the limit `held`; the state of the tool is `missing`, which is no fault"},
    {.verb = FaultVerb::disabled,
     .name = "disabled",
     .place = FaultPlace::tracker,
     .meaning = "a wired tool is unplugged from its tracker",
     .value = "number of the tool",
     .default_value = 1,
     .min = 1,
     .max = 8,
     .remark = "the limit `held`; the state of the tool is `disabled`, which is no fault"},
}};

std::string_view place_text(FaultPlace place) {
  constexpr std::array<std::string_view, 5> texts_of_places{"node", "bus", "node or bus",
                                                            "node, bus or tracker", "tracker"};
  return texts_of_places[static_cast<std::size_t>(place)];
}

std::string default_text(const FaultVerbText& text) {
  if (text.value.empty()) return "";
  return std::string(text.value) + ", " + shortest(text.default_value);
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
  std::string out =
      "| verb | target | effect | `value` and its default | without `duration` | remarks |\n"
      "|---|---|---|---|---|---|\n";
  for (const FaultVerbText& text : texts) {
    out += "| `" + std::string(text.name) + "` | " + std::string(place_text(text.place)) + " | " +
           std::string(text.meaning) + " | " + default_text(text) + " | " +
           (text.is_event ? "once" : "to the end") + " | " + std::string(text.remark) + " |\n";
  }
  return out;
}

}  // namespace godobject
