"""Table of docs/faults.md with the reaction of a rig to each fault, for a rig on one bus."""
import dataclasses
import re
import tomllib
from pathlib import Path

DOCUMENT = Path(__file__).parents[2] / "docs" / "faults.md"
BEGIN, END = "<!-- fault promises: begin -->", "<!-- fault promises: end -->"
# Defaults of keys missing in the scene (docs/scenes.md), s.
DEFAULTS = {"stale_after": 3e-3, "lost_after": 0.1, "heartbeat_timeout": 0.5}
TRAVEL_S = 1.5  # time in which every joint of the scene moves by its max_slip


@dataclasses.dataclass(frozen=True)
class Promise:
    played: str  # words in the table
    always: dict  # name of the fault: its time, as text
    maybe: frozenset
    motors: str  # "torque stays", "run down", "watchdog", "off at once"


def promises():
    """Returns the lines of the list."""
    table = DOCUMENT.read_text().partition(BEGIN)[2].partition(END)[0]
    usual = dict(re.findall(r"^- `(\w+)` within (.+)$", table, re.M))
    others = re.search(r"^- others within (.+)$", table, re.M)[1]
    rows = re.findall(r"^- `([^`]+)`: (.+?)(?: \(possibly (.+)\))?; ([a-z ]+)$", table, re.M)
    return [Promise(played, {name: time or usual.get(name, others)
                             for name, time in re.findall(r"`(\w+)`(?: within ([^,]+))?", always)},
                    frozenset(re.findall(r"`(\w+)`", maybe)), motors)
            for played, always, maybe, motors in rows]


class Times:
    """Times of a scene, s."""

    def __init__(self, scene):
        self.scene = tomllib.loads(Path(scene).read_text())
        self.keys = DEFAULTS | {key: value for key, value in self.scene["device"].get("supervision", {}).items()
                                if key in DEFAULTS}
        self.keys["lost_after"] = max(self.keys["lost_after"], self.keys["stale_after"])
        self.cycle = self.scene["step"] if "step" in self.scene else self.scene["scene"]["step"]

    @property
    def loss(self):
        """Time until a missing sample is a fault."""
        return self.keys["stale_after"] + self.keys["lost_after"]

    @property
    def ramp(self):
        """Time in which the torque of every drive ramps down."""
        return max(d["torque_max_Nm"] / d["torque_rate_Nm_per_s"] for d in self.scene["device"]["drive"])

    def of(self, words, duration=0):
        """Returns the time of a text like "2 `heartbeat_timeout` + 2 cycles"."""
        if "travel" in words:
            return TRAVEL_S
        known = self.keys | {"duration": duration}
        return sum(self._term(term.strip(), known) for term in words.split("+"))

    def _term(self, term, known):
        factor, _, unit = term.rpartition(" ")
        if unit == "cycles":
            return float(factor) * self.cycle
        return float(factor or 1) * known[unit.strip("`")]


def words_for(promise, times):
    """Returns the fault in the words for rig.toml: encoders are nodes 1 and 2, the first drive is 11, the stop 21."""
    words = (promise.played.replace("ENCODER", "bus=can0 node=1").replace("DRIVE", "bus=can0 node=11")
             .replace("STOP", "bus=can0 node=21").replace("OTHER", "2"))
    for key in ("stale_after", "lost_after"):
        words = re.sub(rf"([\d.]+)\*{key}", lambda m: f"{float(m[1]) * times.keys[key]:g}", words)
    return words


def duration_of(words):
    found = re.search(r"duration=([\d.]+)", words)
    return float(found[1]) if found else 0
