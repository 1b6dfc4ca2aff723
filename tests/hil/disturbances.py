"""Means of tests/hil/test_disturbances.py: a line with random bytes, a small disk, a stepped clock, and the checks of files."""
import csv
import ctypes
import os
import pty
import random
import re
import select
import shutil
import struct
import subprocess
import threading
import time
import tty
from pathlib import Path

import pytest

DOCUMENT = Path(__file__).parents[2] / "docs" / "faults.md"
_LIBC = ctypes.CDLL(None, use_errno=True)
_NEW_USER, _NEW_MOUNTS = 0x10000000, 0x00020000  # flags of unshare(2)


def table():
    """Returns {name: (faults that come, faults that may come, torque, files)} of the list "Disturbances"."""
    text = DOCUMENT.read_text().partition("<!-- disturbances: begin -->")[2].partition("<!-- disturbances: end -->")[0]
    rows = {}
    for name, faults, torque, files in re.findall(r"^- `([^`]+)`[^:]*: ([^;]+); ([^;]+); (\w+)", text, re.M):
        always, _, maybe = faults.partition("possibly")
        rows[name] = set(re.findall(r"`(\w+)`", always)), set(re.findall(r"`(\w+)`", maybe)), torque, files
    return rows


class Line:
    """A pseudo-terminal in front of a simulator's: it passes all bytes on, and random ones to the host."""

    def __init__(self, terminal, seed):
        self._master, self._slave = pty.openpty()
        self._far = os.open(terminal, os.O_RDWR | os.O_NOCTTY)
        for end in (self._slave, self._far):
            tty.setraw(end)
        self.path = os.ttyname(self._slave)
        self._random = random.Random(seed)
        self._noise_until = 0.0
        self.num_bytes = 0  # random ones
        self._hung_up, self._stop = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def add_noise(self, seconds):
        self._noise_until = time.monotonic() + seconds

    def hang_up(self):
        """Closes the host's end, as an adapter that is unplugged. The simulator's stays open."""
        self._hung_up.set()

    def _run(self):
        noise_at = 0.0
        while not self._hung_up.is_set():
            ready = select.select([self._master, self._far], [], [], 0.005)[0]
            if self._far in ready:
                os.write(self._master, os.read(self._far, 4096))
            if self._master in ready:
                os.write(self._far, os.read(self._master, 4096))
            now = time.monotonic()
            if noise_at < now < self._noise_until:
                noise_at = now + self._random.uniform(0, 0.1)  # s
                self.num_bytes += os.write(self._master, self._random.randbytes(self._random.randint(1, 100)))

        os.close(self._master)
        os.close(self._slave)
        while not self._stop.is_set():
            if select.select([self._far], [], [], 0.005)[0]:
                os.read(self._far, 4096)

    def close(self):
        self._hung_up.set()
        self._stop.set()
        self._thread.join()
        os.close(self._far)


def why_no_small_disk():
    """Returns why this user cannot mount a file system in a name space of its own; empty if it can."""
    if not shutil.which("unshare"):
        return "no unshare: apt-get install util-linux"
    tried = subprocess.run(["unshare", "-rm", "mount", "-t", "tmpfs", "none", "/mnt"], capture_output=True, text=True)
    return tried.stderr.strip() or "unshare fails" if tried.returncode else ""


def mount_small_disk(folder, num_bytes):
    """For preexec_fn: mounts a file system of this size, which the program and its descendants alone see."""
    user, group = os.getuid(), os.getgid()

    def mount():
        assert _LIBC.unshare(_NEW_USER | _NEW_MOUNTS) == 0
        Path("/proc/self/setgroups").write_text("deny")
        Path("/proc/self/uid_map").write_text(f"0 {user} 1")
        Path("/proc/self/gid_map").write_text(f"0 {group} 1")
        assert _LIBC.mount(b"none", str(folder).encode(), b"tmpfs", 0, f"size={num_bytes}".encode()) == 0

    return mount


class SteppedClock:
    """Time of day of a program, which the test steps."""

    def __init__(self, folder):
        compiler = shutil.which("cc")
        if not compiler:
            pytest.skip("no cc: apt-get install gcc")
        library, self._file = folder / "stepped_clock.so", folder / "step"
        subprocess.run([compiler, "-shared", "-fPIC", "-o", library, Path(__file__).parent / "stepped_clock.c", "-ldl"],
                       check=True)
        self.step(0)
        self.environment = os.environ | {"LD_PRELOAD": str(library), "STEPPED_CLOCK": str(self._file)}

    def step(self, seconds):
        with open(self._file, "r+b" if self._file.exists() else "wb") as file:
            file.write(struct.pack("d", seconds))


def trace_rows(path, step_s):
    """Returns the rows of a trace as dictionaries; asserts that each is whole and that no cycle is missing."""
    text = path.read_text()
    assert text.endswith("\n"), f"cut row: {text[-100:]!r}"
    head, *rows = list(csv.reader(text.splitlines()))
    assert all(len(row) == len(head) for row in rows), "a row is not whole"
    cycles = [round(float(row[0]) / step_s) for row in rows]
    assert cycles == list(range(len(rows))), f"cycles are missing: {gaps(cycles)}"
    return [dict(zip(head, row)) for row in rows]


def gaps(cycles):
    return [(a, b) for a, b in zip(cycles, cycles[1:]) if b != a + 1]


def replayed_cycles(program, path):
    """Returns the number of cycles that `godobject replay` has repeated without a difference."""
    result = subprocess.run([program, "replay", path], capture_output=True, text=True)
    found = re.search(r"replayed (\d+) cycles, .*, identical", result.stdout)
    assert result.returncode == 0 and found, result.stdout + result.stderr
    return int(found[1])
