"""Means of tests/hil/test_disturbances.py: a line with random bytes, a small disk, a stepped clock, and the checks of files."""
import csv
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


def small_disk(rig, folder, num_bytes):
    """Mounts a file system of this size at a folder, in the name space of a program that ends with the rig. Returns the folder
    as others see it."""
    holder = rig.start(["unshare", "-rm", "sh", "-c", f'mount -t tmpfs -o size={num_bytes} none "$1" && echo ready && exec sleep 600',
                        "sh", folder], stdout=subprocess.PIPE)
    assert holder.popen.stdout.readline() == b"ready\n", holder.error_text()
    return Path(f"/proc/{holder.popen.pid}/root") / folder.relative_to("/")


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
