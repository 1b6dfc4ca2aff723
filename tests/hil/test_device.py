"""godobject.device: a program of the user as the device. Its force ends on every way out of the run."""
import itertools
import json
import math
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

from godobject import hil
from godobject.device import Device, Pose

pytestmark = pytest.mark.simulated

SOURCE = Path(__file__).parents[2]


class Pushed(Device):
    """Is pushed into the wall within 1 s. Sends a signal to the run once it was pushed back for 0.3 s."""

    def __init__(self, run, signum):
        self.process, self.signum = run, signum
        self.start_s = self.felt_s = self.sent_s = self.zero_s = None

    def read(self):
        self.start_s = self.start_s or time.monotonic()
        if self.felt_s and not self.sent_s and time.monotonic() > self.felt_s + 0.3:
            self.sent_s = time.monotonic()
            self.process.send_signal(self.signum)
        if self.zero_s:
            self.process.send_signal(signal.SIGCONT)
        return Pose(p_m=(0.095 * min(time.monotonic() - self.start_s, 1), 0, 0))

    def show(self, wrench):
        self.last = wrench
        if self.felt_s is None and wrench.f_N[0] < -1:
            self.felt_s = time.monotonic()
        if self.sent_s and self.zero_s is None and wrench.f_N == (0, 0, 0):
            self.zero_s = time.monotonic()


@pytest.mark.parametrize("signum", [signal.SIGTERM, signal.SIGKILL, signal.SIGSTOP])
def test_the_force_ends_with_the_run(program, tmp_path, signum):
    path = str(tmp_path / "hand.sock")
    run = subprocess.Popen([program, "run", SOURCE / "sim/scenes/wall.toml", "--device", path, "--quiet",
                            "--report", tmp_path / "report.json", "--record", tmp_path / "run.godo"],
                           cwd=tmp_path, stderr=subprocess.PIPE)
    try:
        device = Pushed(run, signum)
        device.run(path, duration_s=8)
        assert device.felt_s, "the wall was not felt"
        assert device.zero_s - device.sent_s < 0.5  # 20 ms after the last wrench; the rest for a busy machine
        assert device.last.f_N == device.last.tau_Nm == (0, 0, 0) and not device.last.live
    finally:
        if signum == signal.SIGSTOP:
            run.send_signal(signal.SIGCONT)
            run.terminate()
        try:
            run.communicate(timeout=20)
        finally:
            run.kill()
    replay = subprocess.run([program, "replay", tmp_path / "run.godo"], capture_output=True, text=True)
    assert replay.returncode == 0, replay.stdout + replay.stderr
    assert replay.stdout.endswith(" s, identical\n")
    assert ("was cut after cycle" in replay.stderr) == (signum == signal.SIGKILL)
    if signum == signal.SIGKILL:
        return
    report = json.loads((tmp_path / "report.json").read_text())["device_program"]
    assert report["samples"] > 500 and report["malformed"] == 0 and report["connections"] == 1
    assert not os.path.exists(path)


class Unreliable(Device):
    """Rests. Every tenth pose is late, of the future, or none; now and then it is 0.5 m away."""

    def __init__(self):
        self.number = itertools.count()
        self.sent = {"malformed": 0, "late": 0, "samples": 0}

    def read(self):
        nan, now, number = math.nan, time.monotonic(), next(self.number)
        wrong = [("malformed", Pose((nan, 0, 0))), ("malformed", Pose((0, math.inf, 0))), ("malformed", Pose((0, 0, 1e9))),
                 ("malformed", Pose((0, 0, 0), (0, 0, 0, 0))), ("malformed", Pose((0, 0, 0), (nan, 0, 0, 0))),
                 ("malformed", Pose((0, 0, 0), t_s=nan)), ("malformed", Pose((0, 0, 0), t_s=now + 5)),
                 ("late", Pose((0, 0, 0), t_s=now - 0.2)), ("late", Pose((0, 0, 0), t_s=0.0))]
        kind, pose = ("samples", Pose((0, 0.5 * (number > 150 and number % 100 > 80), 0), t_s=now - 1e-3))
        if number > 50 and number % 10 == 0:
            kind, pose = wrong[number // 10 % len(wrong)]
        self.sent[kind] += 1
        return pose


def test_late_and_absurd_samples_are_counted_and_jumps_are_walked(program, tmp_path):
    with hil.Process([program, "run", SOURCE / "sim/scenes/wall.toml", "--device", tmp_path / "hand.sock", "--quiet",
                      "--report", tmp_path / "report.json", "--trace", tmp_path / "t.csv"]) as run:
        device = Unreliable()
        device.run(str(tmp_path / "hand.sock"), duration_s=5)
        run.stop()
    text = json.loads((tmp_path / "report.json").read_text())
    report, missed = text["device_program"], text["timing"]["missed_deadlines"]
    # A busy machine leaves samples out, and makes others late.
    sent = device.sent
    assert 20 < report["malformed"] <= sent["malformed"] and 10 < report["late"] and 200 < report["samples"] <= sent["samples"]
    trace = hil.read_trace(tmp_path / "t.csv")
    assert not any(math.isnan(x) for name, column in trace.items() for x in column)
    y = trace["peg.target.y"]
    # 2 m/s; a step after missed periods has the way of all of them.
    assert max(abs(b - a) for a, b in zip(y, y[1:])) <= 2e-3 * (1 + missed) * (1 + 1e-9) and max(y) > 5e-3


def test_a_device_without_a_run_is_told_the_command(tmp_path):
    with pytest.raises(OSError, match="start `godobject run SCENE --device"):
        Device().run(str(tmp_path / "none.sock"), patience_s=0.1)
