"""Process data of CANopen nodes: the objects of a PDO, and their values with names and units."""
from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from .frames import RPDO1, TPDO1, TPDO2, drive_state

if TYPE_CHECKING:
    from .scene import Node

Objects = tuple[tuple[int, int, int], ...]  # index, sub-index and bits of each object of a PDO
Maps = dict[tuple[str, int, str], Objects]  # by bus, node id and kind of the frame

# Without a profile, and meaning of objects that a profile maps in their place.
_STANDARD: dict[tuple[str, str], Objects] = {
    ("drive", RPDO1): ((0x6040, 0, 16), (0x6071, 0, 16)),
    ("drive", TPDO1): ((0x6041, 0, 16), (0x6064, 0, 32), (0x6077, 0, 16)),
    ("drive", TPDO2): ((0x606C, 0, 32), (0x6061, 0, 8), (0x603F, 0, 16)),
    ("encoder", TPDO1): ((0x6004, 0, 32),),
    ("button", TPDO1): ((0x6000, 1, 8),)}
_SIGNED = {0x6030, 0x6060, 0x6061, 0x6064, 0x606C, 0x6071, 0x6077, 0x607A, 0x60B2, 0x60FF}
# Names of torques, positions and velocities are followed by their units.
_NAMES = {0x6000: "inputs", 0x6004: "position", 0x6030: "speed", 0x603F: "error_code", 0x6040: "controlword",
          0x6041: "statusword", 0x6060: "mode", 0x6061: "mode", 0x6064: "position", 0x606C: "velocity", 0x6071: "torque",
          0x6077: "torque", 0x607A: "target_position", 0x60B2: "torque_offset", 0x60FD: "digital_inputs",
          0x60FF: "target_velocity"}
_LINE = re.compile(r"^#   (\S+) node (\d+) ([rt]pdo[1-4]) +(.*)$", re.M)
_OBJECT = re.compile(r"([0-9A-F]{4})h:([0-9A-F]{2}):(\d+)")


def maps_of(text: str) -> Maps:
    """Returns the PDOs of profiles, as `godobject check --full` prints them."""
    return {(bus, int(node), kind): tuple((int(index, 16), int(sub, 16), int(bits)) for index, sub, bits in _OBJECT.findall(line))
            for bus, node, kind, line in _LINE.findall(text)}


def values_of(node: Node, kind: str, objects: Objects | None, data: bytes) -> dict[str, Any]:
    """Returns the values of a PDO of a Node; empty if its length is another.

    kind: TPDO1, ... objects: of its profile; None: the standard ones.
    """
    standard = _STANDARD.get((node.kind, kind), ())
    objects = standard if objects is None else objects
    size = sum(bits for _, _, bits in objects) // 8
    if not objects or len(data) < size or (len(data) > size and node.kind != "button"):  # a button may have more inputs
        return {}
    values: dict[str, Any] = {}
    at = 0
    for i, (index, sub, bits) in enumerate(objects):
        taken, at = data[at:at + bits // 8], at + bits // 8
        meant = index if index in _NAMES or i >= len(standard) else standard[i][0]
        values |= _value(node, meant, sub, int.from_bytes(taken, "little", signed=meant in _SIGNED))
    return values


def _value(node: Node, index: int, sub: int, number: int) -> dict[str, Any]:
    """Returns the value of an object, in SI units too."""
    name = _NAMES.get(index, "")
    if not name:
        return {f"{index:04X}h:{sub:02X}": number}
    if name == "statusword":
        return {name: number, "state": drive_state(number)}
    if name.endswith("position"):
        return {f"{name}_counts": number, f"{name}_{node.unit}": node.position(number)}
    if name.endswith("velocity"):
        return {f"{name}_{node.unit}_per_s": node.sign * number / node.counts_per_unit}
    if name.startswith("torque"):
        return {f"{name}_Nm": 1e-3 * number * node.torque_rated_Nm}
    return {f"{name}{sub}" if sub > 1 else name: number}
