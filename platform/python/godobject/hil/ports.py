"""Ends of buses: SLCAN on a terminal, SocketCAN; a listener with all frames received so far."""
from __future__ import annotations

import os
import re
import select
import socket
import struct
import threading
import time
import tty
from pathlib import Path
from collections.abc import Callable
from typing import Any, Protocol, TypeVar

from .clocks import Moment, moment, now
from .errors import HilError, NotAvailable, TimedOut
from .frames import Frame, make_frame

T = TypeVar("T")
_POLL_S = 0.002


def wait_for(condition: Callable[[], T], timeout_s: float, wanted: str) -> T:
    """Returns the first true value of condition(), evaluated every 2 ms. Raises TimedOut after timeout_s, s.

    wanted: the condition in words, for the message.
    """
    __tracebackhide__ = True
    end = time.monotonic() + timeout_s
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() >= end:
            raise TimedOut(f"not within {timeout_s:g} s: {wanted}")
        time.sleep(_POLL_S)


class Port(Protocol):
    """An end of a bus."""
    name: str

    def receive(self, timeout_s: float) -> list[tuple[float, int, bytes, bool]]:
        """Returns (time, id, data, extended) of each frame that has arrived; empty after timeout_s."""

    def send(self, can_id: int, data: bytes, extended: bool) -> None:
        """Sends a data frame."""

    def close(self) -> None:
        """Closes this end."""


class SlcanPort:
    """SLCAN on a terminal: an adapter, or a pseudo-terminal of godobject.

    path: the terminal. bit_rate_code: S0 to S8; 8 is 1 Mbit/s. Frames have the time at which they were read.
    """
    _FRAME = re.compile(rb"t([0-9A-Fa-f]{3})([0-8])((?:[0-9A-Fa-f]{2})*)$|T([0-9A-Fa-f]{8})([0-8])((?:[0-9A-Fa-f]{2})*)$")

    def __init__(self, path: str, bit_rate_code: int = 8) -> None:
        self.name = f"slcan:{path}"
        try:
            self._fd = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError as error:
            raise NotAvailable(error.strerror or str(error), self.name, "give the terminal that the rig has printed") from None
        tty.setraw(self._fd)
        self._text = b""
        os.write(self._fd, b"\rC\rS%d\rO\r" % bit_rate_code)

    def receive(self, timeout_s: float) -> list[tuple[float, int, bytes, bool]]:
        if not select.select([self._fd], [], [], timeout_s)[0]:
            return []
        read = os.read(self._fd, 65536)
        if not read:
            raise OSError("the other end is closed")
        *lines, self._text = (self._text + read).split(b"\r")
        time_s, frames = now(), []
        for line in lines:
            match = self._FRAME.search(line.rpartition(b"\a")[2])  # a refusal is a BEL without CR
            if match:
                cob_id, _, data, extended_id, _, extended_data = match.groups()
                text = data if cob_id else extended_data
                frames.append((time_s, int(cob_id or extended_id, 16), bytes.fromhex(text.decode()), cob_id is None))
        return frames

    def send(self, can_id: int, data: bytes, extended: bool = False) -> None:
        kind = b"T%08X" if extended else b"t%03X"
        try:
            os.write(self._fd, kind % can_id + b"%d" % len(data) + data.hex().upper().encode() + b"\r")
        except OSError as error:
            raise HilError(f"frame {can_id:03X} not sent: {error.strerror}", self.name, "is the rig still running?") from None

    def close(self) -> None:
        try:
            os.write(self._fd, b"C\r")
        except OSError:  # the other end is gone already
            pass
        os.close(self._fd)


def why_no_socketcan(interface: str) -> str:
    """Returns the reason why a SocketCAN interface cannot be used; empty if it can."""
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except (AttributeError, OSError) as error:
        return f"this machine has no AF_CAN: {error}"
    flags = Path("/sys/class/net") / interface / "flags"
    if not flags.exists():
        return f"no interface {interface}"
    return "" if int(flags.read_text(), 16) & 1 else f"interface {interface} is down"


class SocketCanPort:
    """A SocketCAN interface. Frames have the kernel's stamps."""
    _HEADER = struct.Struct("=IB3x8s")
    _STAMP = struct.Struct("@qq")
    _TIMESTAMPNS = 35  # SO_TIMESTAMPNS of Linux
    _EXTENDED, _REMOTE, _ERROR = 1 << 31, 1 << 30, 1 << 29

    def __init__(self, interface: str) -> None:
        self.name = f"socketcan:{interface}"
        if reason := why_no_socketcan(interface):
            raise NotAvailable(reason, self.name, f"ip link add {interface} type vcan; ip link set {interface} up")
        self._socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        self._socket.setsockopt(socket.SOL_SOCKET, self._TIMESTAMPNS, 1)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self._socket.bind((interface,))

    def receive(self, timeout_s: float) -> list[tuple[float, int, bytes, bool]]:
        if not select.select([self._socket], [], [], timeout_s)[0]:
            return []
        packet, ancillary, _, _ = self._socket.recvmsg(16, 64)
        stamp_s = now()
        for level, kind, value in ancillary:
            if level == socket.SOL_SOCKET and kind == self._TIMESTAMPNS and len(value) >= self._STAMP.size:
                seconds, nanoseconds = self._STAMP.unpack_from(value)
                stamp_s = seconds + 1e-9 * nanoseconds
        can_id, size, data = self._HEADER.unpack(packet)
        if can_id & (self._REMOTE | self._ERROR):
            return []
        extended = bool(can_id & self._EXTENDED)
        return [(stamp_s, can_id & (0x1FFFFFFF if extended else 0x7FF), data[:size], extended)]

    def send(self, can_id: int, data: bytes, extended: bool = False) -> None:
        header = can_id | (self._EXTENDED if extended else 0)
        try:
            self._socket.send(self._HEADER.pack(header, len(data), data))
        except OSError as error:
            raise HilError(f"frame {can_id:03X} not sent: {error.strerror}", self.name, "ip -details link show") from None

    def close(self) -> None:
        self._socket.close()


def open_port(address: str) -> Port:
    """Opens an address of godobject: slcan:TERMINAL or socketcan:INTERFACE."""
    kind, _, place = address.partition(":")
    if kind == "slcan":
        return SlcanPort(place.partition(",")[0])
    if kind == "socketcan":
        return SocketCanPort(place)
    raise HilError(f"no bus of kind {kind!r}", address, "give slcan:TERMINAL or socketcan:INTERFACE")


class Listener:
    """All frames of a bus, received in a thread of its own. It can also send, as another node.

    bus: name in the scene. port: open; the listener closes it. canopen: False for a bus of ODrives or moteus.
    frames: all so far; only ever appended to.
    """

    def __init__(self, bus: str, port: Port, canopen: bool = True) -> None:
        self.bus, self.port, self.canopen = bus, port, canopen
        self.frames: list[Frame] = []
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._listen, name=f"listener {bus}", daemon=True)
        self._thread.start()

    def _listen(self) -> None:
        while not self._stop.is_set():
            try:
                received = self.port.receive(0.05)
            except OSError:  # the other end is gone
                return
            self.frames.extend([make_frame(t, self.bus, i, data, extended, self.canopen) for t, i, data, extended in received])

    def mark(self) -> int:
        """Returns a position in the frames; since(mark) returns the later ones."""
        return len(self.frames)

    def since(self, mark: int = 0, **wanted: Any) -> list[Frame]:
        """Returns the frames after a mark whose fields have the wanted values: since(mark, kind=hil.EMCY, node=3)."""
        return [f for f in self.frames[mark:] if all(getattr(f, k) == v for k, v in wanted.items())]

    def between(self, begin_wall_s: float, end_wall_s: float) -> list[Frame]:
        """Returns the frames of a time of day, s since 1970."""
        return [f for f in self.frames if begin_wall_s <= f.time <= end_wall_s]

    def wait_for(self, condition: Callable[[Frame], object], timeout_s: float, wanted: str, mark: int = 0) -> Frame:
        """Returns the first frame since `mark` for which condition(frame) holds. Raises TimedOut after timeout_s."""
        seen = mark

        def find() -> Frame | None:
            nonlocal seen
            new = self.frames[seen:]
            seen += len(new)
            return next((f for f in new if condition(f)), None)

        found = wait_for(find, timeout_s, f"{wanted} on {self.bus}")
        assert found is not None
        return found

    def send(self, can_id: int, data: bytes = b"", extended: bool = False) -> Moment:
        """Sends a data frame and returns its moment."""
        sent = moment(f"frame {can_id:03X} to {self.bus}")
        self.port.send(can_id, data, extended)
        return sent

    def close(self) -> None:
        """Ends the thread and closes the port."""
        if self._stop.is_set():
            return
        self._stop.set()
        self._thread.join(2)
        self.port.close()
