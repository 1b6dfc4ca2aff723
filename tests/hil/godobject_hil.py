"""Tools for hardware-in-the-loop tests of godobject: the programs on both ends of a bus, an outsider that
listens, decoded CANopen frames, faults, and waits with a timeout.

Works on a simulated rig (pseudo-terminals or vcan) and on real hardware; see README.md.
"""
import dataclasses
import json
import signal
import struct
import subprocess
import tempfile
import threading
import time
from pathlib import Path

import can

SYNC, NMT, EMCY, TPDO1, RPDO1, TPDO2, HEARTBEAT, OTHER = (
    "sync", "nmt", "emcy", "tpdo1", "rpdo1", "tpdo2", "heartbeat", "other")

NMT_STATES = {0x00: "boot-up", 0x04: "stopped", 0x05: "operational", 0x7F: "pre-operational"}
NMT_COMMANDS = {0x01: "start", 0x02: "stop", 0x80: "pre-operational", 0x81: "reset node",
                0x82: "reset communication"}
# CiA 402: statusword under its mask, in the order in which they must be tried.
DRIVE_STATES = ((0x004F, 0x0000, "not ready to switch on"), (0x004F, 0x0040, "switch on disabled"),
                (0x006F, 0x0021, "ready to switch on"), (0x006F, 0x0023, "switched on"),
                (0x006F, 0x0027, "operation enabled"), (0x006F, 0x0007, "quick stop active"),
                (0x004F, 0x000F, "fault reaction active"), (0x004F, 0x0008, "fault"))


@dataclasses.dataclass(frozen=True)
class Frame:
    """One CAN frame with its CANopen meaning (predefined connection set, CiA 301)."""
    time: float  # s, of reception by the outsider
    id: int
    data: bytes
    kind: str
    node: int  # 0: all nodes, or none

    @property
    def nmt_state(self):
        return NMT_STATES.get(self.data[0]) if self.kind == HEARTBEAT and self.data else None

    @property
    def nmt_command(self):
        return NMT_COMMANDS.get(self.data[0]) if self.kind == NMT and len(self.data) == 2 else None

    @property
    def controlword(self):
        return struct.unpack_from("<H", self.data)[0]

    @property
    def target_per_mille(self):
        """Target torque 6071h of an RPDO1, per mille."""
        return struct.unpack_from("<h", self.data, 2)[0]

    @property
    def drive_state(self):
        """State in a drive's TPDO1."""
        word = struct.unpack_from("<H", self.data)[0]
        return next((name for mask, value, name in DRIVE_STATES if word & mask == value), "unknown")

    @property
    def actual_per_mille(self):
        """Actual torque 6077h in a drive's TPDO1, per mille."""
        return struct.unpack_from("<h", self.data, 6)[0]

    @property
    def position_counts(self):
        """Position in an encoder's TPDO1 (6004h), or in a drive's (6064h)."""
        return struct.unpack_from("<I", self.data)[0] if len(self.data) == 4 else struct.unpack_from(
            "<i", self.data, 2)[0]

    @property
    def emcy_code(self):
        return struct.unpack_from("<H", self.data)[0]


def decode(message):
    """Returns the Frame of a python-can message."""
    function, node = message.arbitration_id & 0x780, message.arbitration_id & 0x7F
    kind = OTHER
    if not message.is_extended_id and not message.is_remote_frame and not message.is_error_frame:
        kinds = {0x000: NMT, 0x080: EMCY if node else SYNC, 0x180: TPDO1, 0x200: RPDO1, 0x280: TPDO2,
                 0x700: HEARTBEAT}
        kind = kinds.get(function, OTHER)
    data = bytes(message.data)
    if kind == NMT and len(data) == 2:
        node = data[1]
    return Frame(message.timestamp, message.arbitration_id, data, kind, node)


class TimedOut(AssertionError):
    pass


def wait_for(condition, timeout_s, what):
    """Returns the first true value of condition(); raises TimedOut."""
    end = time.monotonic() + timeout_s
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() >= end:
            raise TimedOut(f"not within {timeout_s} s: {what}")
        time.sleep(0.002)


class Outsider:
    """Listens on a bus in its own thread, and can send."""

    def __init__(self, bus):
        self.bus = bus  # python-can bus
        self.frames = []  # append-only
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def _listen(self):
        while not self._stop.is_set():
            try:
                message = self.bus.recv(0.05)
            except (can.CanError, OSError):  # the other end is gone
                return
            if message is not None:
                self.frames.append(decode(message))

    def mark(self):
        """Returns a position in the frames; since(mark) returns the later ones."""
        return len(self.frames)

    def since(self, mark, **wanted):
        return [f for f in self.frames[mark:] if all(getattr(f, k) == v for k, v in wanted.items())]

    def wait_for(self, condition, timeout_s, what, mark=0):
        """Returns the first frame since `mark` for which condition(frame) holds."""
        return wait_for(lambda: next((f for f in self.frames[mark:] if condition(f)), None), timeout_s, what)

    def send(self, cob_id, data=b""):
        self.bus.send(can.Message(arbitration_id=cob_id, data=data, is_extended_id=False))

    def close(self):
        self._stop.set()
        self._thread.join(2)
        self.bus.shutdown()


class Process:
    """A program with its output in a file, ended by a signal with a timeout."""

    def __init__(self, command, **popen):
        self.command = [str(c) for c in command]
        self.errors = tempfile.TemporaryFile("w+")
        self.popen = subprocess.Popen(self.command, stderr=self.errors, text=True, **popen)

    def running(self):
        return self.popen.poll() is None

    def error_text(self):
        self.errors.seek(0)
        return self.errors.read()

    def stop(self, timeout_s=10):
        """Sends SIGINT and returns the exit code; after timeout_s kills the program and returns None."""
        if self.running():
            self.popen.send_signal(signal.SIGINT)
        try:
            return self.popen.wait(timeout_s)
        except subprocess.TimeoutExpired:
            self.popen.kill()
            self.popen.wait()
            return None


class Simulator(Process):
    """`godobject simulate`, with commands on its standard input."""

    def __init__(self, program, scene, arguments):
        super().__init__([program, "simulate", scene, "--control", "-", *arguments], stdin=subprocess.PIPE,
                         stdout=subprocess.PIPE, bufsize=1)
        self.buses, self.taps = {}, {}
        for line in self.popen.stdout:
            if line.strip() == "ready":
                return
            kind, name, where = line.split(maxsplit=2)
            (self.buses if kind == "bus" else self.taps)[name.rstrip(":")] = where.split()[-1]
        raise RuntimeError(f"{' '.join(self.command)}: {self.error_text()}")

    def command_line(self, line):
        self.popen.stdin.write(line + "\n")
        self.popen.stdin.flush()
        reply = json.loads(self.popen.stdout.readline())
        assert reply.get("ok"), f"{line}: {reply.get('error')}"
        return reply

    def fault(self, words):
        """Injects a fault, e.g. "drop bus=can0 node=4 value=0.1 duration=0.5". See docs/faults.md."""
        return self.command_line("fault " + words)

    def clear(self):
        return self.command_line("clear")

    def status(self):
        return self.command_line("status")

    def torque_Nm(self):
        """Returns the largest absolute torque of a motor, N m."""
        return max((abs(d["torque_Nm"]) for d in self.status()["drives"]), default=0)


class Host(Process):
    """`godobject run` on real buses."""

    def __init__(self, program, scene, buses, folder, arguments=()):
        self.report_path, self.record_path = Path(folder) / "report.json", Path(folder) / "record.log"
        addresses = [word for bus in buses for word in ("--bus", bus)]
        super().__init__([program, "run", scene, *addresses, "--report", self.report_path,
                          "--record", self.record_path, *arguments], stdout=subprocess.DEVNULL)

    def report(self):
        return json.loads(self.report_path.read_text())

    def faults(self):
        """Returns the names of the faults of the run, which must have ended."""
        return {fault["name"] for fault in self.report()["faults"]}

    def fault_text(self):
        return "\n".join(f"{fault['name']}: {fault['text']}" for fault in self.report()["faults"])


def is_sanitized(program):
    """True if the program has a sanitizer, which makes it several times slower and delays its end."""
    code = Path(program).read_bytes()
    return b"__tsan_init" in code or b"__asan_init" in code


def was_starved(host):
    """True if the faults of an ended run are those of a stalling machine, without an injected fault: a drive received
    no command for its `deadline_ms`, or the host no answer for `stale_after`."""
    faults = host.faults()
    watchdog = faults == {"emergency"} and "0x8250" in host.fault_text()
    return watchdog or (bool(faults) and faults <= {"drive_silent", "sample_stale", "held"})


def read_candump(path):
    """Yields (interface, id, data) for each frame of a candump log."""
    for line in Path(path).read_text().splitlines():
        if not line.startswith("("):
            continue
        _, interface, frame = line.split()[:3]
        cob_id, data = frame.split("#", 1)
        yield interface, int(cob_id, 16), bytes.fromhex(data)
