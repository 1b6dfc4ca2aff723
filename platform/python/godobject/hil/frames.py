"""CAN frames with their CANopen meaning (CiA 301, CiA 402), candump logs, traces."""
from __future__ import annotations

import csv
import re
import struct
from pathlib import Path
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from .errors import HilError

if TYPE_CHECKING:
    from .scene import Scene

SYNC, NMT, EMCY, HEARTBEAT, OTHER = "sync", "nmt", "emcy", "heartbeat", "other"
TPDO1, TPDO2, TPDO3, TPDO4 = "tpdo1", "tpdo2", "tpdo3", "tpdo4"
RPDO1, RPDO2, RPDO3, RPDO4 = "rpdo1", "rpdo2", "rpdo3", "rpdo4"

NMT_STATES = {0x00: "boot-up", 0x04: "stopped", 0x05: "operational", 0x7F: "pre-operational"}
NMT_COMMANDS = {0x01: "start", 0x02: "stop", 0x80: "pre-operational", 0x81: "reset node",
                0x82: "reset communication"}
# CiA 402: statusword under its mask, in the order in which they must be tried.
DRIVE_STATES = ((0x004F, 0x0000, "not ready to switch on"), (0x004F, 0x0040, "switch on disabled"),
                (0x006F, 0x0021, "ready to switch on"), (0x006F, 0x0023, "switched on"),
                (0x006F, 0x0027, "operation enabled"), (0x006F, 0x0007, "quick stop active"),
                (0x004F, 0x000F, "fault reaction active"), (0x004F, 0x0008, "fault"))
# Predefined connection set: function code of the COB-ID.
_KINDS = {0x080: EMCY, 0x180: TPDO1, 0x200: RPDO1, 0x280: TPDO2, 0x300: RPDO2, 0x380: TPDO3, 0x400: RPDO3, 0x480: TPDO4,
          0x500: RPDO4, 0x700: HEARTBEAT}


def drive_state(statusword: int) -> str:
    """Returns the CiA 402 state of a statusword 6041h, e.g. "operation enabled"."""
    return next((name for mask, value, name in DRIVE_STATES if statusword & mask == value), "unknown")


class Frame(NamedTuple):
    """One CAN frame.

    time: reception, s since 1970. bus: name in the scene, or interface in a log. id: CAN identifier.
    kind: SYNC, NMT, EMCY, TPDO1 to TPDO4, RPDO1 to RPDO4, HEARTBEAT or OTHER, which are all frames of a bus of ODrives or
    moteus. node: its node id; 0: all nodes, or none.
    Properties raise HilError if the frame is too short for them.
    """
    time: float
    bus: str
    id: int
    data: bytes
    kind: str
    node: int
    extended: bool = False

    def _get(self, form: str, offset: int = 0) -> int:
        if len(self.data) < offset + struct.calcsize(form):
            raise HilError(f"{self.kind} of node {self.node} has {len(self.data)} bytes", self.bus,
                           "check len(frame.data), or that the node has the layout of docs/canopen.md")
        value: int = struct.unpack_from(form, self.data, offset)[0]
        return value

    @property
    def nmt_state(self) -> str | None:
        """State in a heartbeat; None in another frame."""
        return NMT_STATES.get(self.data[0]) if self.kind == HEARTBEAT and self.data else None

    @property
    def nmt_command(self) -> str | None:
        """Command of an NMT frame; None in another frame."""
        return NMT_COMMANDS.get(self.data[0]) if self.kind == NMT and len(self.data) == 2 else None

    @property
    def controlword(self) -> int:
        """Controlword 6040h of an RPDO1."""
        return self._get("<H")

    @property
    def target_per_mille(self) -> int:
        """Target torque 6071h of an RPDO1, per mille of the rated torque."""
        return self._get("<h", 2)

    @property
    def statusword(self) -> int:
        """Statusword 6041h of a drive's TPDO1."""
        return self._get("<H")

    @property
    def drive_state(self) -> str:
        """CiA 402 state in a drive's TPDO1."""
        return drive_state(self.statusword)

    @property
    def actual_per_mille(self) -> int:
        """Actual torque 6077h in a drive's TPDO1, per mille of the rated torque."""
        return self._get("<h", 6)

    @property
    def position_counts(self) -> int:
        """Position in an encoder's TPDO1 (6004h), or in a drive's (6064h), counts."""
        return self._get("<I") if len(self.data) == 4 else self._get("<i", 2)

    @property
    def emcy_code(self) -> int:
        """Error code of an EMCY, e.g. 0x8250."""
        return self._get("<H")


def _meaning(can_id: int) -> tuple[str, int]:
    node = can_id & 0x7F
    if can_id == 0:
        return NMT, 0
    if can_id == 0x080:
        return SYNC, 0
    return _KINDS.get(can_id & 0x780, OTHER), node


_MEANINGS = [_meaning(can_id) for can_id in range(0x800)]


def make_frame(time_s: float, bus: str, can_id: int, data: bytes, extended: bool = False, canopen: bool = True) -> Frame:
    """Returns a frame with its meaning in the predefined connection set. canopen: False for a bus without CANopen."""
    kind, node = _MEANINGS[can_id & 0x7FF] if canopen and not extended else (OTHER, 0)
    if kind == NMT and len(data) == 2:
        node = data[1]
    return Frame(time_s, bus, can_id, data, kind, node, extended)


_LOG_LINE = re.compile(r"\((\d+\.\d+)\)\s+(\S+)\s+([0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})#(?:#[0-9A-Fa-f])?([0-9A-Fa-f]*)(?:\s+[RT])?$")
_REMOTE = re.compile(r"\(\d+\.\d+\)\s+\S+\s+[0-9A-Fa-f]+#R\d?(\s+[RT])?$")


def read_candump(path: str | Path, scene: Scene | None = None) -> Iterator[Frame]:
    """Yields the data frames of a log of `candump -l`, or of `run --record`. Raises HilError with the wrong line.

    scene: that of the log; None: all buses are CANopen. A last line that was cut off is omitted.
    """
    buses: dict[str, bool] = {}
    lines = Path(path).read_text(errors="replace").splitlines(keepends=True)
    for number, line in enumerate(lines, 1):
        text = line.strip()
        if not text or text.startswith("#") or _REMOTE.match(text):
            continue
        found = _LOG_LINE.match(text)
        if not found or len(found[4]) % 2:
            if number == len(lines) and not line.endswith("\n"):
                return
            raise HilError(f"no frame: {text!r}", f"{path}:{number}", "give a log of candump -l or of run --record")
        bus = found[2]
        canopen = buses.setdefault(bus, scene is None or scene.is_canopen(bus))
        yield make_frame(float(found[1]), bus, int(found[3], 16), bytes.fromhex(found[4]), len(found[3]) == 8, canopen)


def read_trace(path: str | Path) -> dict[str, list[float]]:
    """Returns the columns of a trace of `run --trace` by name; units are those of docs/how-to/record-and-analyse.md.

    `t_bus` is the time of day, s since 1970, on real buses. A field without a number is NaN.
    """
    with open(path, newline="") as file:
        rows = csv.reader(file)
        names = next(rows, None)
        if not names:
            raise HilError("the file has no line of column names", str(path), "give a file of run --trace")
        columns: dict[str, list[float]] = {name: [] for name in names}
        for number, row in enumerate(rows, 2):
            if len(row) != len(names):
                raise HilError(f"{len(row)} fields in place of {len(names)}", f"{path}:{number}",
                               "the run was killed: delete its last line")
            for name, text in zip(names, row):
                columns[name].append(_number(text))
    return columns


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return float("nan")
