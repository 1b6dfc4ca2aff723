"""godobject.device: a program of the user as the device. Its force ends on every way out of the run."""
import json
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

from godobject.device import Device, Pose

pytestmark = pytest.mark.simulated

SOURCE = Path(__file__).parents[2]


class Pushed(Device):
    """Is pushed into the wall within 1 s. Sends a signal to the run once it was pushed back for 0.3 s."""

    def __init__(self, run, signum):
        self.process, self.signum = run, signum
        self.felt_s = self.sent_s = self.zero_s = None

    def read(self, t_s):
        if self.felt_s and not self.sent_s and time.monotonic() > self.felt_s + 0.3:
            self.sent_s = time.monotonic()
            self.process.send_signal(self.signum)
        if self.zero_s:
            self.process.send_signal(signal.SIGCONT)
        return Pose(p_m=(0.095 * min(t_s, 1), 0, 0))

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


def test_a_device_without_a_run_is_told_the_command(tmp_path):
    with pytest.raises(OSError, match="start `godobject run SCENE --device"):
        Device().run(str(tmp_path / "none.sock"), patience_s=0.1)
