"""Buses, nodes and units of a scene, as `godobject check --full` prints them, and decoded frames."""
from __future__ import annotations

import dataclasses
import functools
import os
import re
import shutil
import struct
import subprocess
import tomllib
from pathlib import Path
from typing import Any

from . import frames
from .errors import HilError, NotAvailable, Refused
from .frames import Frame
from .pdo import Maps, maps_of, values_of

_CHECK_S = 60


def find_program(program: str | Path | None = None) -> str:
    """Returns the path of godobject: the argument, else $GODOBJECT_PROGRAM, else that of PATH."""
    path = str(program or os.environ.get("GODOBJECT_PROGRAM") or shutil.which("godobject") or "")
    if not path or not Path(path).exists():
        raise NotAvailable("no program godobject", path, "build or install it, then set GODOBJECT_PROGRAM, or PATH")
    return path


@dataclasses.dataclass(frozen=True)
class Node:
    """An encoder, drive or button of the scene.

    kind: "encoder", "drive" or "button". unit: "rad" or "m" of its joint. Position of the joint, in this unit:
    home + sign (counts - offset_counts) / counts_per_unit. modulus_counts: count at which it wraps; 0: 2^32.
    torque_rated_Nm, torque_max_Nm: of the motor. torque_rate_Nm_per_s: at which the host ramps it down.
    """
    kind: str
    bus: str
    node_id: int
    joint: str = ""
    protocol: str = "canopen"
    profile: str = ""
    unit: str = "rad"
    counts_per_unit: float = 1.0
    sign: int = 1
    offset_counts: int = 0
    home: float = 0.0
    modulus_counts: int = 0
    torque_rated_Nm: float = 0.0
    torque_max_Nm: float = 0.0
    torque_rate_Nm_per_s: float = 0.0

    @property
    def name(self) -> str:
        """Name in messages, e.g. "elbow drive" or "button node 5"."""
        return f"{self.joint} {self.kind}" if self.joint else f"{self.kind} node {self.node_id}"

    def position(self, counts: int) -> float:
        """Returns the joint coordinate of a count, rad or m; without turns before the last wrap, as at power-up."""
        modulus = self.modulus_counts or 1 << 32
        difference = (counts - self.offset_counts + modulus // 2) % modulus - modulus // 2
        return self.home + self.sign * difference / self.counts_per_unit


@dataclasses.dataclass(frozen=True)
class Message:
    """A decoded frame. name: e.g. "elbow drive status".

    values: numbers, each with its unit in its name, e.g. torque_Nm; a text: state, nmt_state, command.
    """
    frame: Frame
    name: str
    node: Node | None
    values: dict[str, Any]

    def __str__(self) -> str:
        values = ", ".join(f"{key} {_text(key, value)}" for key, value in self.values.items())
        return f"{self.frame.bus} {self.frame.id:03X} {self.name:24} {values or self.frame.data.hex(' ')}"


def _text(key: str, value: Any) -> str:
    if key in ("statusword", "controlword", "error_code"):
        return f"0x{value:04X}"
    return f"{value:.5g}" if isinstance(value, float) else str(value)


class Scene:
    """Buses and nodes of a scene file. Raises Refused with the program's own messages if the scene has errors.

    config: the values in effect, with the tables and keys of docs/scenes.md. step_s: period, s.
    buses: their names. nodes: by (bus, node id). supervision: times of [device.supervision], s.
    """

    def __init__(self, path: str | Path, program: str | Path | None = None) -> None:
        self.path = str(path)
        self.program = find_program(program)
        self.config, self._maps = _effective(self.program, self.path, _stamp(self.path))
        device = self.config.get("device", {})
        self.step_s = float(self.config["scene"]["step"])
        self.buses: list[str] = [bus["name"] for bus in self.config.get("bus", [])]
        self.supervision: dict[str, float] = dict(device.get("supervision", {}))
        self.trackers: list[str] = [tracker["name"] for tracker in device.get("tracker", [])]
        self._units = {joint["name"]: "m" if joint.get("kind") == "slider" else "rad" for joint in device.get("joint", [])}
        self.nodes: dict[tuple[str, int], Node] = {}
        # Of the buses that have no CANopen.
        self._protocols = {drive["bus"]: drive["protocol"] for drive in device.get("drive", []) if drive["protocol"] != "cia402"}
        for kind in ("encoder", "button", "drive"):
            for table in device.get(kind, []):
                node = self._node(kind, table)
                self.nodes[node.bus, node.node_id] = node

    def _node(self, kind: str, table: dict[str, Any]) -> Node:
        sign = table.get("counts_sign", 1) if kind == "drive" else table.get("sign", 1)
        known = {field.name for field in dataclasses.fields(Node)} - {"kind", "sign", "unit"}
        given = {key: value for key, value in table.items() if key in known}
        return Node(kind=kind, sign=sign, unit=self._units.get(table.get("joint", ""), "rad"), **given)

    def _of_kind(self, kind: str) -> list[Node]:
        return [node for node in self.nodes.values() if node.kind == kind]

    @property
    def drives(self) -> list[Node]:
        """Drives, in the order of the scene."""
        return self._of_kind("drive")

    @property
    def has_sync(self) -> bool:
        """True if its host sends SYNC: a bus has CANopen nodes."""
        return bool(set(self.buses) - set(self._protocols))

    def is_canopen(self, bus: str) -> bool:
        """False for a bus of ODrives or moteus."""
        return bus not in self._protocols

    @property
    def encoders(self) -> list[Node]:
        """Encoders, in the order of the scene."""
        return self._of_kind("encoder")

    def node(self, joint: str, kind: str = "drive") -> Node:
        """Returns the drive, or the encoder, of a joint."""
        for node in self._of_kind(kind):
            if node.joint == joint:
                return node
        raise HilError(f"no {kind} of a joint '{joint}'", self.path,
                       "its joints are " + ", ".join(node.joint for node in self._of_kind(kind)))

    @property
    def loss_s(self) -> float:
        """Time in which a missing sample becomes a fault: `stale_after` + `lost_after`, s."""
        stale_s, lost_s = self.supervision["stale_after"], self.supervision["lost_after"]
        return stale_s + max(stale_s, lost_s)

    @property
    def ramp_s(self) -> float:
        """Longest time in which the host ramps the torque of a drive down, s."""
        return max((node.torque_max_Nm / node.torque_rate_Nm_per_s for node in self.drives if node.torque_rate_Nm_per_s),
                   default=0.0)

    def decode(self, frame: Frame) -> Message:
        """Returns the frame with names and units of the scene. Frames of moteus stay without values."""
        if protocol := self._protocols.get(frame.bus):
            return self._decode_odrive(frame) if protocol == "odrive" else Message(frame, "", None, {})
        node = self.nodes.get((frame.bus, frame.node))
        owner = node.name if node else f"node {frame.node}" if frame.node else ""
        if frame.node and frame.node == self.supervision.get("host_node_id"):
            owner = "host"
        data, kind = frame.data, frame.kind
        if kind == frames.SYNC:
            return Message(frame, "SYNC", None, {})
        if kind == frames.NMT:
            return Message(frame, "NMT " + (owner or "all nodes"), node, {"command": frame.nmt_command or data.hex()})
        if kind == frames.HEARTBEAT and data:
            return Message(frame, f"{owner} heartbeat", node, {"nmt_state": frame.nmt_state or f"{data[0]:02X}"})
        if kind == frames.EMCY and len(data) == 8:
            return Message(frame, f"{owner} EMCY", node, {"error_code": frame.emcy_code})
        if node is None:
            return Message(frame, f"{owner} {kind}".strip() if kind != frames.OTHER else "", node, {})
        name = _PDO_NAMES.get((node.kind, kind))
        return Message(frame, f"{node.joint or node.name} {name}" if name else f"{node.name} {kind}", node,
                       values_of(node, kind, self._maps.get((frame.bus, node.node_id, kind)), data))

    def _decode_odrive(self, frame: Frame) -> Message:
        node = None if frame.extended else self.nodes.get((frame.bus, frame.id >> 5))
        name, form, keys = _ODRIVE.get(frame.id & 0x1F, ("", "", ()))
        if node is None or not name or len(frame.data) < struct.calcsize(form):
            return Message(frame, "" if node is None else f"{node.joint} drive message", node, {})
        return Message(frame, f"{node.joint} {name}", node, dict(zip(keys, struct.unpack_from(form, frame.data))))


# ODrive, CAN Simple: name, layout and values of each message.
_ODRIVE: dict[int, tuple[str, str, tuple[str, ...]]] = {
    0x01: ("drive heartbeat", "<IB", ("error", "axis_state")),
    0x02: ("emergency stop", "", ()),
    0x07: ("axis state command", "<I", ("requested_state",)),
    0x09: ("encoder estimates", "<ff", ("position_turns", "velocity_turns_per_s")),
    0x0B: ("controller mode", "<II", ("control_mode", "input_mode")),
    0x0E: ("torque command", "<f", ("torque_Nm",)),
    0x18: ("clear errors", "", ()),
    0x1C: ("torques", "<ff", ("target_Nm", "torque_Nm"))}


def changed_scene(path: str | Path, folder: str | Path, *changes: tuple[str, str]) -> str:
    """Writes the scene with texts replaced into a folder, beside copies of the files that it names; returns its path.

    changes: (old, new) each. Raises HilError if the scene has no such text.
    """
    source, text = Path(path).resolve(), Path(path).read_text()
    for old, new in changes:
        if old not in text:
            raise HilError(f"no text {old!r} to replace", str(path), "take a text of the scene as it is written there")
        text = text.replace(old, new)
    made = Path(folder) / source.name
    for beside in source.parent.iterdir():
        named = re.search(rf"[\"/']({re.escape(beside.stem)}|{re.escape(beside.name)})[\"/']", text)
        if named and beside.is_dir():
            shutil.copytree(beside, made.parent / beside.name, dirs_exist_ok=True)
        elif named and beside != source:
            shutil.copy(beside, made.parent / beside.name)
    made.write_text(text)
    return str(made)


_PDO_NAMES = {("drive", frames.TPDO1): "drive status", ("drive", frames.TPDO2): "drive event",
              ("drive", frames.RPDO1): "torque command", ("encoder", frames.TPDO1): "position",
              ("button", frames.TPDO1): "inputs"}


def _stamp(path: str) -> float:
    try:
        return max(file.stat().st_mtime for file in {Path(path), *Path(path).parent.glob("*.toml")})
    except OSError as error:
        raise HilError(error.strerror or "unreadable", path, "give the path of a scene file (docs/scenes.md)") from None


@functools.lru_cache(maxsize=64)
def _effective(program: str, path: str, stamp: float) -> tuple[dict[str, Any], Maps]:
    """Returns the effective configuration and the PDOs that `check --full` prints; stamp: last change of the file and those beside it."""
    done = subprocess.run([program, "check", "--full", path], capture_output=True, text=True, timeout=_CHECK_S)
    if done.returncode != 0:
        raise Refused(done.stderr.strip() or f"check has exit code {done.returncode}", path, f"godobject check {path}")
    text = done.stdout.partition("# effective configuration")[2]
    return tomllib.loads(text.partition("\n# composition")[0]), maps_of(text)
