"""Disturbances of whole runs: the reactions in the list "Disturbances" of docs/faults.md, with trace, input log and report.
Each line has its test here."""
import contextlib
import re
import resource
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest

import disturbances
from disturbances import table
from godobject import hil

pytestmark = [pytest.mark.repeats_if_starved, pytest.mark.simulated]

STEP_S = 0.01  # step in rig.toml
WATCHDOG_S = 0.1  # deadline_ms of patient-402.toml
LATE_S = {"pty": 0.08, "vcan": 0.5}  # delays of the programs in between, which share a processor in a guest
UNWRITTEN_S = 0.5  # that a killed run loses (docs/running.md)
DISK_BYTES = 4 << 20
NOISE_S = 10
HELD = {"held"}  # a busy machine holds the pose of so short a run for more than 5 % of it
TESTED = ["stopped", "disk full", "disk full for a while", "folder removed", "bus gone", "clock stepped", "flood",
          "random bytes"]


class Disturbed:
    """A run with trace, input log and report that commands torque."""

    def __init__(self, rig, folder, tier="pty"):
        self.rig, self.folder, self.late_s, self.run = rig, folder, LATE_S[tier], None

    def start(self, *arguments, **popen):
        self.folder.mkdir()
        for _ in range(hil.ATTEMPTS):
            marks = self.rig.marks()
            self.run = self.rig.start_run("--trace", self.folder / "trace.csv", "--record", self.folder / "run.godo", *arguments,
                                          record=False, **popen)
            if self.rig.wait_until_enabled(self.run, marks=marks):
                self.rig.wait_for_torque()
                time.sleep(1)
                return
        pytest.fail(f"godobject run was not enabled {hil.ATTEMPTS} times:\n{self.run.error_text()}")

    def expect(self, name, event=None, torque=True):
        """Expects the torque of the list's line, ends the run, and expects its faults and files. Returns the trace's rows, and
        the number of cycles in the input log. event: the disturbance."""
        always, maybe, promised, files = table()[name]
        if torque:
            self.expect_torque(promised, event)
        code = self.run.stop()
        faults = self.run.faults()
        assert always <= faults <= always | maybe | HELD, self.run.fault_text()
        assert code == (1 if faults else 0), self.run.error_text()
        return self.expect_files(files)

    def expect_torque(self, promised, event):
        if promised == "torque stays":
            mark = self.rig.bus.mark()
            time.sleep(0.3)
            self.rig.wait_for_torque()
            assert self.run.running and not self.rig.bus.since(mark, kind=hil.NMT), self.run.error_text()
            return
        assert promised == "watchdog"
        self.rig.assert_zero_torque(event, WATCHDOG_S + 2 * STEP_S + self.late_s, for_s=0.5)

    def expect_files(self, promised):
        report = self.run.report()
        rows = disturbances.trace_rows(self.folder / "trace.csv", STEP_S)
        replayed = disturbances.replayed_cycles(self.rig.scene.program, self.folder / "run.godo")
        lost = {Path(name).name: int(count) for fault in report["faults"] if fault["name"] == "file_incomplete"
                for name, count in re.findall(r"^(\S+) could not be written in full: .*; it lacks (\d+) lines", fault["text"])}
        # The first row is the state before the first cycle.
        assert len(rows) - 1 + lost.get("trace.csv", 0) == report["cycles"]
        assert replayed + lost.get("run.godo", 0) == report["cycles"]
        assert (lost == {}) == (promised == "complete"), lost
        if lost:
            assert set(lost) == {"trace.csv", "run.godo"} and len(rows) > 50, lost
        return rows, replayed


@pytest.fixture
def disturbed(rig, tmp_path, tier):
    return Disturbed(rig, tmp_path / "out", tier)


@pytest.fixture
def line(rig):
    """The terminal of the host's bus, with the test between its ends."""
    made = disturbances.Line(rig.terminal(), seed=20)
    rig.addresses[rig.scene.buses[0]] = f"slcan:{made.path}"
    yield made
    rig.end_programs()
    made.close()


def test_every_line_has_its_test():
    assert sorted(table()) == sorted(TESTED)


def test_stopped(disturbed):
    disturbed.start()
    event = disturbed.run.send_signal(signal.SIGSTOP)
    time.sleep(1)
    disturbed.run.send_signal(signal.SIGCONT)
    disturbed.expect("stopped", event=event)


@pytest.mark.parametrize("name", ["disk full", "disk full for a while"])
def test_disk_full(disturbed, rig, tmp_path, name):
    if reason := disturbances.why_no_small_disk():
        pytest.skip(reason)
    tmp_path.joinpath("disk").mkdir()
    disk = disturbances.small_disk(rig, tmp_path / "disk", DISK_BYTES)
    disturbed.folder = disk / "out"
    disturbed.start()
    ballast = disk / "ballast"
    with open(ballast, "wb", buffering=0) as file, contextlib.suppress(OSError):
        while True:
            file.write(bytes(4096))
    time.sleep(1)
    full = (disturbed.folder / "trace.csv").stat().st_size
    time.sleep(0.5)
    assert (disturbed.folder / "trace.csv").stat().st_size == full, "the disk is not full"
    if name != "disk full":
        ballast.unlink()
    rows, replayed = disturbed.expect(name)
    assert abs(len(rows) - 1 - replayed) < UNWRITTEN_S / STEP_S, "one file lacks more than was not written yet"


def test_file_size_limit(disturbed):
    disturbed.start(preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000)))
    time.sleep(2)
    disturbed.expect("disk full")


def test_folder_removed(disturbed):
    disturbed.start()
    shutil.rmtree(disturbed.folder)
    hil.wait_for((disturbed.folder / "run.godo").exists, 5, "the files again")
    disturbed.expect("folder removed")


def test_bus_gone(disturbed, request, tier):
    if tier == "pty":
        line = request.getfixturevalue("line")
        disturbed.start()
        event = hil.moment("the terminal hangs up")
        line.hang_up()
        disturbed.expect("bus gone", event)
        return
    interface = disturbed.rig.address().rpartition(":")[2]
    disturbed.start()
    event = hil.moment("the interface goes down")
    try:
        subprocess.run(["ip", "link", "set", interface, "down"], check=True)
        disturbed.expect("bus gone", event)
    finally:
        subprocess.run(["ip", "link", "set", interface, "up"], check=True)


def test_simulator_killed(program, scene, tmp_path):
    with hil.Rig(scene, program=program, folder=tmp_path) as rig:
        disturbed = Disturbed(rig, tmp_path / "out")
        disturbed.start()
        rig.simulator.kill()
        time.sleep(1)
        disturbed.expect("bus gone", torque=False)  # the motors are gone too


def test_clock_stepped(disturbed, tmp_path, program):
    if hil.is_sanitized(program):
        pytest.skip("a sanitizer must be the first library")
    clock = disturbances.SteppedClock(tmp_path)
    disturbed.start(env=clock.environment)
    for step_s in (3600, -3600, 0):
        clock.step(step_s)
        time.sleep(0.5)
    t_bus = [float(row["t_bus"]) for row in disturbed.expect("clock stepped")[0]]
    assert max(b - a for a, b in zip(t_bus, t_bus[1:])) < 1 and min(b - a for a, b in zip(t_bus, t_bus[1:])) > 0
    assert abs(t_bus[-1] - hil.now()) < 5


def test_flood(disturbed, rig):
    disturbed.start()
    mark = rig.bus.mark()
    rig.fault("flood", duration=2)
    time.sleep(2)
    assert len([f for f in rig.bus.since(mark) if f.extended]) > 3000
    disturbed.expect("flood")


def test_random_bytes(disturbed, request, tier):
    if tier != "pty":
        pytest.skip("no terminal")
    line = request.getfixturevalue("line")
    disturbed.start()
    line.add_noise(NOISE_S)
    time.sleep(NOISE_S)
    assert line.num_bytes > 3000
    disturbed.expect("random bytes")
    assert disturbed.run.report()["bus"][0]["counters"]["error_frames"] > 50
