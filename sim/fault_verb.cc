#include "sim/fault_verb.h"

#include <algorithm>

#include "sim/key.h"

namespace godobject {
namespace {

constexpr std::array<FaultVerbText, num_fault_verbs> texts{{
    {.verb = FaultVerb::drop,
     .name = "drop",
     .place = FaultPlace::anywhere,
     .meaning = "frames vanish, those it sends and those it should receive",
     .value = "share of the frames",
     .default_value = 1,
     .min = 0,
     .max = 1,
     .reaction = "up to three in a row are bridged; more: the pose is held, the force fades (`held`). For "
                 "`lost_after`, "
                 "of an encoder's: `sample_stale`; of a drive's: `drive_silent`, and its own watchdog stops "
                 "the motor. A "
                 "tracker's replies: asked for "
                 "again; with all of them gone its tools are `stale`, which is no fault"},
    {.verb = FaultVerb::duplicate,
     .name = "duplicate",
     .place = FaultPlace::bus_or_node,
     .meaning = "frames come twice",
     .value = "share of the frames",
     .default_value = 1,
     .min = 0,
     .max = 1,
     .reaction = "none: the second copy is not later than the first and is left out"},
    {.verb = FaultVerb::delay,
     .name = "delay",
     .place = FaultPlace::anywhere,
     .meaning = "what arrives can be read only later",
     .value = "s",
     .default_value = 2e-3,
     .min = 0,
     .max = 1,
     .reaction = "less than `stale_after`: none, the samples are as much older; more: `held`, and after "
                 "`lost_after` `sample_stale`, or `drive_silent`. A tracker's poses: later; more than its "
                 "`stale_after`: `stale`"},
    {.verb = FaultVerb::corrupt,
     .name = "corrupt",
     .place = FaultPlace::anywhere,
     .meaning = "frames are destroyed on the wire: error frame, and sent again by the controller",
     .value = "share of the frames",
     .default_value = 0.1,
     .min = 0,
     .max = 1,
     .reaction = "few: none but bus load and error counters. Most of them: the sender goes bus-off, then as "
                 "`bus-off`. Of a tracker: `bad_crc`, and asked again"},
    {.verb = FaultVerb::stuck,
     .name = "stuck",
     .place = FaultPlace::node,
     .meaning = "the sensor keeps showing where it is now",
     .value = {},
     .reaction =
         "with `max_slip` of the joint's drive, once the joint has moved that far: `sensors_disagree`. "
         "Without: "
         "none, nothing tells it from a joint at rest; the jump at its end, if there is one: as `spike`"},
    {.verb = FaultVerb::spike,
     .name = "spike",
     .place = FaultPlace::node,
     .meaning = "the sensor shows a place that far off, for one sample or for the duration",
     .value = "rad or m",
     .default_value = 1,
     .min = -1e3,
     .max = 1e3,
     .is_event = true,
     .reaction = "one sample: it is not used, that step holds the last one. Three of five: "
                 "`sample_implausible`"},
    {.verb = FaultVerb::wrap,
     .name = "wrap",
     .place = FaultPlace::node,
     .meaning = "the sensor's count wraps at this many counts, fewer than its calibration says",
     .value = "counts",
     .default_value = 256,
     .min = 2,
     .max = 4294967296.0,
     .reaction = "a jump of its count: `sample_implausible`"},
    {.verb = FaultVerb::nan,
     .name = "nan",
     .place = FaultPlace::node,
     .meaning = "the sensor has no value: NaN where the wire carries floats, 8000 0000h where it carries "
                "integers",
     .value = {},
     .reaction = "`sample_implausible` at the third"},
    {.verb = FaultVerb::reboot_node,
     .name = "reboot-node",
     .place = FaultPlace::node,
     .meaning = "the node loses its power for the duration and boots",
     .value = {},
     .is_event = true,
     .reaction = "`sample_stale` or `drive_silent` while it is away, `node_restarted` with its boot-up "
                 "message"},
    {.verb = FaultVerb::emcy,
     .name = "emcy",
     .place = FaultPlace::node,
     .meaning = "the node reports an error; a drive also goes to its state Fault",
     .value = "emergency error code",
     .default_value = 0x1000,
     .min = 1,
     .max = 0xFFFF,
     .is_event = true,
     .reaction = "`emergency`; of a drive also `drive_not_enabled`"},
    {.verb = FaultVerb::bus_off,
     .name = "bus-off",
     .place = FaultPlace::bus_or_node,
     .meaning = "the controller goes bus-off; at the end of the duration it restarts",
     .value = {},
     .is_event = true,
     .reaction = "of a node: as `drop` of all. Of the host: `bus_down`; over a real bus, whose controller is "
                 "another: `sample_stale`, `drive_silent`"},
    {.verb = FaultVerb::restart,
     .name = "restart",
     .place = FaultPlace::bus_or_node,
     .meaning = "the controller starts its way out of bus-off: 128 times 11 recessive bits",
     .value = {},
     .is_event = true,
     .reaction = "none by itself: the faults stay until they are cleared"},
    {.verb = FaultVerb::unplug,
     .name = "unplug",
     .place = FaultPlace::anywhere,
     .meaning = "the plug is pulled; at the end of the duration it is put back",
     .value = {},
     .reaction = "as `drop` of all, and a node's heartbeat: `heartbeat_lost`. A tracker begins anew when "
                 "it is back"},
    {.verb = FaultVerb::id_collision,
     .name = "id-collision",
     .place = FaultPlace::node,
     .meaning = "a second encoder with the node's id, whose count is another, joins the bus",
     .value = {},
     .reaction = "its boot-up message: `node_restarted`. Both answer SYNC at once and go bus-off: then "
                 "`sample_stale` or `drive_silent`"},
    {.verb = FaultVerb::clock_drift,
     .name = "clock-drift",
     .place = FaultPlace::node,
     .meaning = "the node's clock is that much fast",
     .value = "ppm",
     .default_value = 1e4,
     .min = -9e5,
     .max = 9e6,
     .reaction = "none: samples follow SYNC. So slow that the heartbeat's period passes "
                 "`heartbeat_timeout`: `heartbeat_lost`"},
    {.verb = FaultVerb::missing,
     .name = "missing",
     .place = FaultPlace::tracker,
     .meaning = "a tool is hidden from its tracker",
     .value = "number of the tool",
     .default_value = 1,
     .min = 1,
     .max = 8,
     .reaction = "no fault: the limit `held`, the tool's state is `missing`"},
    {.verb = FaultVerb::disabled,
     .name = "disabled",
     .place = FaultPlace::tracker,
     .meaning = "a wired tool is unplugged from its tracker",
     .value = "number of the tool",
     .default_value = 1,
     .min = 1,
     .max = 8,
     .reaction = "no fault: the limit `held`, the tool's state is `disabled`"},
}};

std::string_view place_text(FaultPlace place) {
  constexpr std::array<std::string_view, 4> texts_of_places{"node", "node or bus", "node, bus or tracker",
                                                            "tracker"};
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
      "| verb | of | what happens | `value`, and without one | without `duration` | what the rig does |\n"
      "|---|---|---|---|---|---|\n";
  for (const FaultVerbText& text : texts) {
    out += "| `" + std::string(text.name) + "` | " + std::string(place_text(text.place)) + " | " +
           std::string(text.meaning) + " | " + default_text(text) + " | " +
           (text.is_event ? "once" : "to the end") + " | " + std::string(text.reaction) + " |\n";
  }
  return out;
}

}  // namespace godobject
