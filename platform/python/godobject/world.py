"""A slow simulation of your own around the tool of `godobject run --world NAME`.

    with World("my-world") as world:
        while (tool := world.wait()) is not None:
            push(tool.impulses)                       # your simulation
            world.write([Plane(id=1, p_m=..., n=...)])

The run serves the hand at 1 kHz on these planes, which move by their velocities between two calls of `write`. World
frame, SI units, quaternions w, x, y, z.
"""
import dataclasses
import mmap
import os
import struct
import time
import zlib
from collections.abc import Sequence
from types import TracebackType

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

# platform/session/world.h, platform/linux/shared_world.h
MAX_PLANES, MAX_BODIES, VERSION = 6, 8, 1
SEGMENT_MAGIC, WORLD_MAGIC = 0x31575347, 0x314E4957
RUNS, LIVE, HAS_MOVED = 1, 1, 1
HEADER = np.dtype([("magic", "<u4"), ("version", "<u4"), ("size", "<u4"), ("num_planes", "<u4"), ("state", "<u4"),
                   ("owner", "<u4"), ("step_s", "<f8"), ("reserved", "<u8", 4)])
TOOL = np.dtype([("number", "<u8"), ("t_s", "<f8"), ("t_run_s", "<f8"), ("flags", "<u4"), ("num_bodies", "<u4"),
                 ("f_N", "<f8", 3), ("tau_Nm", "<f8", 3),
                 ("bodies", [("p_m", "<f8", 3), ("q_wxyz", "<f8", 4), ("w_rad_s", "<f8", 3), ("v_m_s", "<f8", 3)],
                  MAX_BODIES),
                 ("planes", [("id", "<u4"), ("reserved", "<u4"), ("p_m", "<f8", 3), ("J_Ns", "<f8", 3)], MAX_PLANES)])
WORLD = np.dtype([("magic", "<u4"), ("version", "<u4"), ("number", "<u8"), ("answers", "<u8"), ("t_s", "<f8"),
                  ("valid_s", "<f8"), ("num_planes", "<u4"), ("reserved", "<u4"),
                  ("planes", [("id", "<u4"), ("flags", "<u4"), ("p_m", "<f8", 3), ("n", "<f8", 3),
                              ("v_m_s", "<f8", 3), ("moved_m", "<f8", 3), ("k_N_m", "<f8"), ("c_Ns_m", "<f8")],
                   MAX_PLANES)])
TOOL_AT = HEADER.itemsize + 8  # behind its sequence
WORLD_AT = TOOL_AT + TOOL.itemsize + 8
SIZE = WORLD_AT + WORLD.itemsize + 8
SEQUENCE, CRC = struct.Struct("<Q"), struct.Struct("<I")


@dataclasses.dataclass
class Plane:
    """A solid near the tool, as the half-space below a plane.

    id: > 0, the same while it is the same contact. p_m: a point. n: unit normal, out of the solid. v_m_s: velocity of
    the solid there. stiffness, damping: of each touching sphere, N/m and N s/m. moved_m: displacement of the solid
    there since the last `write`, by which the run knows the work of the impulses; None: by the velocities.
    """
    id: int
    p_m: ArrayLike
    n: ArrayLike
    v_m_s: ArrayLike = (0.0, 0.0, 0.0)
    stiffness: float = 1000.0
    damping: float = 5.0
    moved_m: ArrayLike | None = None


@dataclasses.dataclass(frozen=True)
class Impulse:
    """Impulse of the tool on a solid since the last `read`, N s, and the point at which it acts, m."""
    J_Ns: Floats
    p_m: Floats


@dataclasses.dataclass(frozen=True)
class Tool:
    """State of the tool after a step. Rows of the arrays are the bodies of the scene, at most eight.

    t_s: CLOCK_MONOTONIC. live: your newest planes are in use. f_N, tau_Nm: of the planes on the tool now, about the
    first body's centre. impulses: by id of the plane.
    """
    number: int
    t_s: float
    t_run_s: float
    live: bool
    positions: Floats
    quaternions: Floats
    angular_velocities: Floats
    velocities: Floats
    f_N: Floats
    tau_Nm: Floats
    impulses: dict[int, Impulse]


class World:
    """The shared memory of a run. patience_s: time to wait for the run, which may still be starting."""

    def __init__(self, name: str, patience_s: float = 10.0) -> None:
        self._memory = _mapped("/dev/shm/" + name, patience_s)
        header = np.frombuffer(self._memory, HEADER, 1)[0]
        self.num_planes = int(header["num_planes"])  # that `write` takes
        self.step_s = float(header["step_s"])
        self._owner = int(header["owner"])
        self._packet = np.frombuffer(self._memory[WORLD_AT:WORLD_AT + WORLD.itemsize], WORLD, 1).copy()
        self._packet["magic"], self._packet["version"] = WORLD_MAGIC, VERSION
        self._sums: dict[int, Floats] = {}
        self._answers, self._t_s = 0, 0.0
        self._due = 0.0

    def __enter__(self) -> "World":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self._memory.close()

    @property
    def is_running(self) -> bool:
        """False once the run has ended, or was killed."""
        header = np.frombuffer(self._memory[:HEADER.itemsize], HEADER, 1)[0]
        return bool(header["state"] == RUNS) and _lives(self._owner)

    def read(self) -> Tool | None:
        """Returns the newest state of the tool; None before the first step."""
        for _ in range(1000):
            sequence = SEQUENCE.unpack_from(self._memory, TOOL_AT - 8)[0]
            tool = np.frombuffer(self._memory[TOOL_AT:TOOL_AT + TOOL.itemsize], TOOL, 1)[0]
            if sequence % 2 == 0 and sequence == SEQUENCE.unpack_from(self._memory, TOOL_AT - 8)[0]:
                break
        else:
            raise OSError("the run was stopped while it wrote: end this program and the run")
        if tool["number"] == 0:
            return None
        self._answers, self._t_s = int(tool["number"]), float(tool["t_s"])
        sums = {int(plane["id"]): plane for plane in tool["planes"] if plane["id"] != 0}
        nothing = np.zeros(3)
        impulses = {i: Impulse(plane["J_Ns"] - self._sums.get(i, nothing), plane["p_m"].copy())
                    for i, plane in sums.items()}
        self._sums = {i: plane["J_Ns"].copy() for i, plane in sums.items()}
        bodies = tool["bodies"][:tool["num_bodies"]]
        return Tool(self._answers, self._t_s, float(tool["t_run_s"]), bool(tool["flags"] & LIVE),
                    bodies["p_m"], bodies["q_wxyz"], bodies["w_rad_s"], bodies["v_m_s"], tool["f_N"], tool["tau_Nm"],
                    impulses)

    def wait(self, rate_hz: float = 60.0) -> Tool | None:
        """Waits for the next period of this rate and a new state, and returns it; None once the run has ended."""
        now, last = time.monotonic(), self._answers
        self._due = max(self._due + 1 / rate_hz, now - 0.1) if self._due else now
        while self.is_running:
            time.sleep(max(self._due - time.monotonic(), 0))
            tool = self.read()
            if tool is not None and tool.number != last:
                return tool
            self._due = time.monotonic() + 0.001
        return None

    def write(self, planes: Sequence[Plane], t_s: float | None = None, valid_s: float = 0.15) -> None:
        """Sends the planes that surround the tool, computed with the impulses of the newest `read`.

        t_s: time of this state on CLOCK_MONOTONIC; default: that of the tool read. valid_s: time for which the run
        may use it, at most 1 s; then the planes are released. Raises ValueError for more planes than the run takes.
        The run refuses and counts packets with values that are no plane, such as NaN.
        """
        if len(planes) > self.num_planes:
            raise ValueError(f"{len(planes)} planes, and this run takes {self.num_planes}: send the nearest")
        packet = self._packet[0]
        packet["number"] += 1
        packet["answers"], packet["valid_s"] = self._answers, valid_s
        packet["t_s"] = self._t_s if t_s is None else t_s
        packet["num_planes"], packet["planes"] = len(planes), np.zeros((), WORLD["planes"].base)
        for i, plane in enumerate(planes):
            moved, flags = ((0.0, 0.0, 0.0), 0) if plane.moved_m is None else (plane.moved_m, HAS_MOVED)
            packet["planes"][i] = (plane.id, flags, plane.p_m, plane.n, plane.v_m_s, moved, plane.stiffness,
                                   plane.damping)
        content = packet.tobytes()
        sequence = SEQUENCE.unpack_from(self._memory, WORLD_AT - 8)[0] | 1
        content += CRC.pack(zlib.crc32(content))
        self._memory[WORLD_AT - 8:WORLD_AT] = SEQUENCE.pack(sequence)  # at once; pack_into goes through zero
        self._memory[WORLD_AT:WORLD_AT + len(content)] = content
        self._memory[WORLD_AT - 8:WORLD_AT] = SEQUENCE.pack(sequence + 1)


def _mapped(path: str, patience_s: float) -> mmap.mmap:
    """Returns the segment of a run, mapped. Raises OSError if there is none in patience_s, or another version."""
    end = time.monotonic() + patience_s
    while True:
        try:
            with open(path, "r+b") as file:
                memory = mmap.mmap(file.fileno(), SIZE)
            header = np.frombuffer(memory[:HEADER.itemsize], HEADER, 1)[0]
            if header["state"] == RUNS and _lives(int(header["owner"])):
                break
            memory.close()
        except (FileNotFoundError, ValueError):
            pass  # not there, or not whole yet
        if time.monotonic() > end:
            raise OSError(f"no run has made {path}: start `godobject run SCENE --world {os.path.basename(path)}`")
        time.sleep(0.05)
    if header["magic"] != SEGMENT_MAGIC or header["version"] != VERSION or header["size"] != SIZE:
        raise OSError(f"{path} is of another version than this module: use the module of the run's program")
    return memory


def _lives(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True
