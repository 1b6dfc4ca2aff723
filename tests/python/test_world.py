"""A slow simulation around the tool of a real run: over the shared memory, in Python and as MuJoCo in node."""
import json
import os
import shutil
import signal
import struct
import subprocess
import time
import uuid
from pathlib import Path

import pytest
from godobject import read_report, read_trace
from godobject.world import WORLD, WORLD_AT, Plane, World

SOURCE = Path(__file__).resolve().parents[2]
PACKAGES = SOURCE / ".cache/peers"

class Run:
    """`godobject run` of the peg of wall.toml without its obstacles, beside a world; ended with the test."""

    def __init__(self, folder):
        text = (SOURCE / "sim/scenes/wall.toml").read_text()
        head, rest = text.split("[[obstacle]]", 1)
        rest = rest[rest.index("# A box of 30"):]
        rest = rest[:rest.index("[motion]")] + """[motion]
position = [0.0, 0.0, 0.0]
amplitude = [0.04, 0.0, 0.0]
frequency_hz = [0.2, 0.0, 0.0]
phase = [-1.5707963267948966, 0.0, 0.0]
"""
        (folder / "peg.toml").write_text(head + rest.replace("position = [0.0, 0.0, 0.0]\n\n[[body.shape]]",
                                                             "position = [-0.04, 0.0, 0.0]\n\n[[body.shape]]"))
        self.name, self.folder, self.program = "godobject-test-" + uuid.uuid4().hex, folder, None

    def start(self):
        self.program = subprocess.Popen(
            [os.environ["GODOBJECT_PROGRAM"], "run", "peg.toml", "--world", self.name, "--duration", "4", "--trace",
             "t.csv", "--report", "report.json"], cwd=self.folder, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def end(self):
        """Waits for the end of the run, and returns its lines and the report of its world."""
        out, lines = self.program.communicate(timeout=60)
        assert self.program.returncode in (0, 1), lines
        assert not Path("/dev/shm", self.name).exists()
        return lines + out, read_report(self.folder / "report.json")["world"]

    def was_held(self):
        """True if a busy machine has let the ended run miss so many deadlines that it may have held the hand."""
        return read_report(self.folder / "report.json")["timing"]["missed_deadlines"] >= 20


@pytest.fixture
def run_later(tmp_path):
    run = Run(tmp_path)
    yield run
    if run.program and run.program.poll() is None:
        run.program.kill()
        run.program.communicate()
        Path("/dev/shm", run.name).unlink(missing_ok=True)


@pytest.fixture
def run(run_later):
    run_later.start()
    return run_later


def take_priority():
    """Gives this process a real-time priority below that of the run, if the machine permits it."""
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    except PermissionError:
        pass


def wall(x=0.035):
    return Plane(1, p_m=(x, 0, 0), n=(-1, 0, 0))


def test_the_tool_is_pushed_by_the_impulses_that_the_world_gets(run_later):
    for _ in range(4):
        run_later.start()
        pushed, lines, report = pushed_by_wall(run_later)
        if not run_later.was_held():
            break
    assert "the world sends planes" in lines
    assert report["malformed"] == 0 and report["packets"] > 50 and report["live"]
    trace = read_trace(run_later.folder / "t.csv")
    assert trace.positions("peg")[:, 0].max() < 0.0225  # at 40 mm without the plane
    assert 4 < pushed < 12  # N s: up to 9 N for some 1.5 s


def pushed_by_wall(run):
    """Presses the tool on a wall; returns the impulse on the wall, N s, and the end of the run."""
    pushed, numbers = 0.0, []
    with World(run.name) as world:
        assert world.num_planes == 6 and world.step_s == 1e-3
        with pytest.raises(ValueError, match="this run takes 6"):
            world.write([wall()] * 7)
        while (tool := world.wait(100)) is not None:
            numbers.append(tool.number)
            assert tool.positions.shape == (1, 3) and tool.quaternions.shape == (1, 4)
            pushed += sum(impulse.J_Ns[0] for impulse in tool.impulses.values())
            world.write([wall()], valid_s=1.0)
    assert numbers == sorted(set(numbers))
    return pushed, *run.end()


def test_absurd_bytes_and_a_killed_world(run):
    with World(run.name) as world:
        while (tool := world.wait(100)) is not None and tool.t_run_s < 2:
            world.write([wall()], valid_s=1.0)
        world.write([Plane(1, p_m=(float("nan"), 0, 0), n=(-1, 0, 0))])
        number = world.read().number
        while world.is_running and world.read().number < number + 2:  # until a whole step has seen it
            time.sleep(0.001)
        with open("/dev/shm/" + run.name, "r+b") as file:  # a torn packet: its CRC is wrong
            file.seek(WORLD_AT - 8)
            sequence = struct.unpack("<Q", file.read(8))[0]
            file.write(os.urandom(WORLD.itemsize))
            file.seek(WORLD_AT - 8)
            file.write(struct.pack("<Q", sequence + 2))
    lines, report = run.end()
    assert "the world is silent: its planes are released" in lines
    assert report["malformed"] == 2 and report["silences"] == 1 and not report["live"]
    assert "world" in lines and "GONE" in lines


def test_a_run_that_was_killed_leaves_its_name_to_the_next(run):
    with World(run.name) as world:
        assert world.is_running
        run.program.send_signal(signal.SIGKILL)
        run.program.wait()
        assert not world.is_running
    assert Path("/dev/shm", run.name).exists()
    with pytest.raises(OSError, match="no run has made"):
        World(run.name, patience_s=0.1)
    program = os.environ["GODOBJECT_PROGRAM"]
    again = subprocess.run([program, "run", "peg.toml", "--world", run.name, "--duration", "0.1"], cwd=run.folder,
                           capture_output=True, text=True, timeout=60)
    assert again.returncode == 0, again.stderr
    assert not Path("/dev/shm", run.name).exists()


@pytest.mark.parametrize("options, message", [
    (["--world", "a/b"], "is no name of shared memory"),
    (["--world", "w", "--fast"], "requires wall time"),
    (["--world", "w", "--record", "x.godo"], "excludes input logs")])
def test_wrong_options_are_refused(tmp_path, options, message):
    done = subprocess.run([os.environ["GODOBJECT_PROGRAM"], "run", str(SOURCE / "sim/scenes/wall.toml"), *options],
                          cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode != 0 and message in done.stderr


def test_mujoco_as_the_slow_world(run_later):
    if not shutil.which("node") or not (PACKAGES / "node_modules/@mujoco/mujoco").is_dir():
        pytest.skip("no node, or no MuJoCo: ./dev study --peers fetches it")
    for _ in range(8):
        world = subprocess.Popen(["node", str(SOURCE / "tests/python/mujoco_world.mjs"), str(PACKAGES), run_later.name,
                                  "3.6"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                 preexec_fn=take_priority)
        assert world.stdout.readline() == "ready\n", world.communicate()  # before the run, whose hand moves
        run_later.start()
        printed, errors = world.communicate(timeout=60)
        assert world.returncode == 0, errors
        _, report = run_later.end()
        block = json.loads(printed)
        if block["longest_s"] < 1 / 60 + 0.03 and not run_later.was_held():
            break  # else either got no processor for longer than the jitter of 30 ms that is promised: again
    else:
        pytest.skip(f"the machine is busy: after 8 runs a period of MuJoCo took {block['longest_s']:.3f} s, or the loop "
                    "missed deadlines")
    assert report["malformed"] == 0 and report["packets"] > 100
    # At 2.5 s the hand is 20 mm beyond the touch. Springs in series: coupling, four corners, the block's.
    force = 0.020 / (1 / 500 + 1 / 4000 + 1 / 400)
    trace = read_trace(run_later.folder / "t.csv")
    pulled = 500 * (0.04 - trace.positions("peg")[(trace.t > 2.4) & (trace.t < 2.6), 0].mean())
    assert abs(pulled / force - 1) < 0.05
    assert abs(block["push"] / force - 1) < 0.2 and block["packets"] > 100  # the largest of single periods
