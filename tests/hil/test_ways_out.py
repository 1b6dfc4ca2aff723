"""Every way out of `godobject run` on the wire: the last frames and the time to zero torque promised in the table
"Ways out" of docs/faults.md. Each row has its test here, or is listed in ELSEWHERE."""
import os
import pty
import re
import resource
import signal
import subprocess
import termios
import time
from pathlib import Path

import pytest

from godobject import hil

pytestmark = pytest.mark.repeats_if_starved

SOURCE = Path(__file__).parents[2]
STEP_S = 0.01  # step in rig.toml
RATED_NM = 0.1
RATE_NM_PER_S = 0.005  # far below that of rig.toml: ramps of 0.2 s or more are distinguishable from a stop
DEADLINE_S = 0.1  # watchdog of the drives in patient-402.toml
SLACK_S = {"pty": 0.08, "vcan": 0.5}  # delays of the programs in between, which share a processor in a guest
END_S = 6  # includes up to 4.5 s of waiting for a stopped terminal
NODES = (1, 2, 11, 12, 21)
DRIVES = (11, 12)

# No core files, because tests kill programs by SIGSEGV.
resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))

RUN_DOWN = ["SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGTSTP", "SIGALRM", "SIGVTALRM", "SIGPROF", "SIGUSR1", "SIGUSR2",
            "SIGIO", "SIGPWR", "SIGSTKFLT", "SIGXCPU", "SIGRTMIN"]
IGNORED = ["SIGPIPE", "SIGXFSZ", "SIGTTOU", "SIGTTIN"]
DEADLY = ["SIGABRT", "SIGSEGV", "SIGBUS", "SIGFPE", "SIGILL", "SIGSYS", "SIGTRAP"]
UNNOTICED = ["SIGKILL", "SIGSTOP"]
OUTPUTS = ["pipe closed", "terminal gone", "terminal stopped", "reader gone", "nobody reads", "file size limit"]
OTHERS = ["last cycle", "second signal", "space bar", "fault of the rig"]
ELSEWHERE = {"terminate": "LastResort.TerminateWritesTheLastFrames",
             "exception": "LastResort.AnExceptionThatEscapesWritesTheLastFrames",
             "stack overflow": "LastResort.AStackOverflowWritesTheLastFrames",
             "endless loop": "", "power loss": ""}  # the host cannot act: test_torque_gone.py


def table():
    """Returns {name: (last frames, time to zero torque)} for each name in the table's first column."""
    text = (SOURCE / "docs/faults.md").read_text().split("<!-- ways out: begin -->")[1]
    rows = text.split("<!-- ways out: end -->")[0].strip().splitlines()[2:]
    ways = {}
    for row in rows:
        way, _, last, zero = [cell.strip() for cell in re.split(r"(?<!\\)\|", row.strip("|"))]
        ways.update({name: (last, zero) for name in re.findall(r"`([^`]+)`", way) if "run ..." not in name})
    return ways


def number(name):
    return {"SIGSTKFLT": 16}.get(name) or getattr(signal, name)


@pytest.fixture
def scene(tmp_path):
    here = Path(__file__).parent
    text = (here / "rig.toml").read_text()
    changed = text.replace("torque_rate_Nm_per_s = 20.0", f"torque_rate_Nm_per_s = {RATE_NM_PER_S}").replace(
        "mass = 0.1", "mass = 0.5")
    assert changed.count(str(RATE_NM_PER_S)) == 2 and "mass = 0.5" in changed
    (tmp_path / "patient-402.toml").write_text((here / "patient-402.toml").read_text())
    (tmp_path / "rig.toml").write_text(changed)
    return str(tmp_path / "rig.toml")


class Run:
    """A run that commands torque, and its frames on the bus."""

    def __init__(self, bus, host, mark, slack_s, end_s):
        self.bus, self.host, self.mark, self.slack_s, self.end_s = bus, host, mark, slack_s, end_s

    def commands(self, mark):
        return [f for f in self.bus.since(mark, kind=hil.RPDO1) if len(f.data) == 4]

    def wait_for_torque(self, per_mille=10):
        mark = self.bus.mark()
        self.bus.wait_for(lambda f: f.kind == hil.RPDO1 and abs(f.target_per_mille) >= per_mille, 5,
                               f"{per_mille} per mille of torque", mark)

    def now(self):
        """Returns position in the frames, time and ramp-down time of an event that happens now."""
        last = {f.node: f for f in self.commands(self.mark)}
        torque_Nm = max(abs(f.target_per_mille) for f in last.values()) * 1e-3 * RATED_NM
        # Commands in transit or of the present cycle may have more torque.
        return self.bus.mark(), hil.now(), torque_Nm / RATE_NM_PER_S + 2 * STEP_S

    def expect_zero(self, way, event):
        mark, t_event, ramp_s = event
        promised = table()[way][1]
        cycles = re.search(r"(\d+) cycles", promised)
        within_s = ("ramp" in promised) * ramp_s + int(cycles.group(1)) * STEP_S
        late = [f for f in self.commands(mark)
                if f.target_per_mille != 0 and f.time - t_event > within_s + self.slack_s]
        assert not late, f"{late[-1].target_per_mille} per mille {late[-1].time - t_event:.3f} s after it, " \
                         f"promised: {promised} = {within_s:.3f} s"

    def expect_last_frames(self, mark):
        """Expects disable voltage with zero torque to every drive, then pre-operational to every node, then no frame."""
        time.sleep(0.1)
        of_host = [f for f in self.bus.since(mark)
                   if f.kind in (hil.SYNC, hil.NMT, hil.RPDO1) or f.kind == hil.HEARTBEAT and f.node not in NODES]
        last = [(f.kind, f.node, f.controlword if f.kind == hil.RPDO1 else f.nmt_command,
                 f.target_per_mille if f.kind == hil.RPDO1 else 0) for f in of_host[-len(DRIVES + NODES):]]
        assert last == [(hil.RPDO1, node, 0, 0) for node in DRIVES] + \
            [(hil.NMT, node, "pre-operational", 0) for node in NODES]

    def end(self, timeout_s=8):
        """Ends the run and returns its exit code."""
        self.host.send_signal(signal.SIGTERM)
        return self.host.wait(timeout_s)


@pytest.fixture
def start(rig, program, tier):
    """Starts `godobject run` and waits for torque."""
    hosts = []
    end_s = END_S * (2 if hil.is_sanitized(program) else 1)

    def begin(*arguments, **popen):
        for _ in range(hil.ATTEMPTS):
            marks = rig.marks()
            host = rig.start_run(*arguments, record=not popen, **popen)
            hosts.append(host)
            if rig.wait_until_enabled(host, marks=marks):
                run = Run(rig.bus, host, marks[rig.bus.bus], SLACK_S.get(tier, 0.08), end_s)
                try:
                    run.wait_for_torque()
                    return run
                except hil.TimedOut:  # in fault, because the machine stalled it
                    run.end()
        pytest.fail(f"godobject run commanded no torque {hil.ATTEMPTS} times")

    yield begin
    for host in hosts:
        if host.running:
            host.kill()


def test_every_row_has_its_test():
    covered = RUN_DOWN + IGNORED + DEADLY + UNNOTICED + OUTPUTS + OTHERS + list(ELSEWHERE)
    assert sorted(table()) == sorted(covered)
    tests = (SOURCE / "tests/platform/rt/test_last_resort.cc").read_text()
    for test in filter(None, ELSEWHERE.values()):
        assert "TEST({}, {})".format(*test.split(".")) in tests


def test_last_cycle(start):
    run = start("--duration", "3")
    run.host.wait(15)
    run.expect_last_frames(run.mark)


@pytest.mark.parametrize("name", RUN_DOWN)
def test_a_signal_runs_down(start, name):
    run = start()
    event = run.now()
    run.host.send_signal(number(name))
    assert run.host.wait(8) in (0, 1), run.host.error_text()
    run.expect_zero(name, event)
    run.expect_last_frames(event[0])
    assert run.host.report()["stopped_by"] == name
    assert f"{name}: the torque runs down" in run.host.error_text()


def test_a_second_signal_is_a_quick_stop(start):
    run = start()
    run.wait_for_torque(15)
    run.host.send_signal(signal.SIGINT)
    time.sleep(0.05)
    event = run.now()
    run.host.send_signal(signal.SIGINT)
    assert run.host.wait(8) == 1
    run.expect_zero("second signal", event)
    run.expect_last_frames(event[0])
    assert {f.node for f in run.commands(event[0]) if f.controlword == 0x0002} == set(DRIVES)
    assert "QUICK STOP" in run.host.error_text()
    assert "quick_stop" in run.host.faults()


@pytest.fixture
def keyboard():
    """A terminal: the end of its keys and that of the program."""
    master, terminal = pty.openpty()
    yield master, terminal
    os.close(terminal)
    os.close(master)


def test_space_bar_is_a_quick_stop(start, keyboard):
    master, terminal = keyboard
    modes = termios.tcgetattr(terminal)
    run = start("--rearm", "auto", stdin=terminal)
    run.wait_for_torque(15)
    os.write(master, b"x\r")  # other keys do nothing
    run.wait_for_torque(15)
    event = run.now()
    os.write(master, b" ")
    assert run.host.wait(8) == 1
    run.expect_zero("space bar", event)
    run.expect_last_frames(event[0])
    assert {f.node for f in run.commands(event[0]) if f.controlword == 0x0002} == set(DRIVES)
    assert "emergency stop: press the space bar\n" in run.host.error_text()
    assert "space bar: QUICK STOP" in run.host.error_text()
    assert run.host.report()["stopped_by"] == "space bar" and "quick_stop" in run.host.faults()
    assert termios.tcgetattr(terminal) == modes


@pytest.mark.simulated
def test_space_bar_ends_the_recovery(start, rig, keyboard):
    run = start("--rearm", "auto", stdin=keyboard[1])
    mark = run.bus.mark()
    rig.fault("unplug", bus="can0", node=1)
    run.host.wait_for_event("the device is lost", 5)
    os.write(keyboard[0], b" ")
    rig.clear()
    assert run.host.wait(8) == 1 and run.host.report()["stopped_by"] == "space bar"
    assert "ARMED" not in run.host.error_text()
    run.expect_last_frames(mark)


@pytest.mark.parametrize("name", ["SIGINT", "SIGSEGV"])
def test_a_terminal_has_its_modes_again(start, keyboard, name):
    modes = termios.tcgetattr(keyboard[1])
    run = start(stdin=keyboard[1])
    assert termios.tcgetattr(keyboard[1])[3] & (termios.ICANON | termios.ECHO) == 0
    run.host.send_signal(number(name))
    run.host.wait(8)
    assert termios.tcgetattr(keyboard[1]) == modes


@pytest.mark.parametrize("name", DEADLY)
def test_a_defect_leaves_time_for_the_last_frames(start, name):
    run = start()
    event = run.now()
    run.host.send_signal(number(name))
    assert run.host.wait(8) == -number(name)
    run.expect_zero(name, event)
    run.expect_last_frames(event[0])
    assert f"ended by {name}; the drives were commanded" in run.host.error_text()


@pytest.mark.parametrize("name", IGNORED)
def test_a_signal_that_ends_nothing(start, name):
    run = start()
    mark = run.bus.mark()
    run.host.send_signal(number(name))
    time.sleep(0.3)
    run.wait_for_torque()
    assert not run.bus.since(mark, kind=hil.NMT)
    assert run.end() in (0, 1)
    run.expect_last_frames(mark)


@pytest.mark.parametrize("name", UNNOTICED)
def test_what_the_host_does_not_notice_is_the_drives(start, rig, name):
    if not rig.is_simulated:
        pytest.skip("asks the simulator for the torque")
    run = start()
    mark, t_event = run.bus.mark(), hil.now()
    run.host.send_signal(number(name))
    frame = run.bus.wait_for(lambda f: f.kind == hil.EMCY and f.node in DRIVES, 5, "a drive's emergency", mark)
    assert frame.time - t_event < DEADLINE_S + run.slack_s
    rig.wait_for_zero_torque(1)
    run.host.kill()


def ends_nothing(run, event, seconds=0.5):
    """Expects that the run continues to command torque, then ends in time. Returns the exit code."""
    time.sleep(seconds)
    run.wait_for_torque()
    assert not run.bus.since(event, kind=hil.NMT)
    mark, t_begin = run.bus.mark(), hil.now()
    code = run.end(2 * run.end_s)
    assert hil.now() - t_begin < run.end_s
    run.expect_last_frames(mark)
    return code


def test_pipe_closed(start):
    reading, writing = os.pipe()
    run = start(stdout=writing, stderr=writing)
    os.close(writing)
    os.read(reading, 20)
    event = run.bus.mark()
    os.close(reading)
    assert ends_nothing(run, event, 2.5) in (0, 1)


def test_terminal_gone(start):
    master, slave = pty.openpty()
    run = start(stdout=slave, stderr=slave)
    os.close(slave)
    event = run.bus.mark()
    os.close(master)
    assert ends_nothing(run, event, 2) in (0, 1)


def test_terminal_stopped(start):
    master, slave = pty.openpty()
    run = start(stdout=slave, stderr=slave)
    event = run.bus.mark()
    termios.tcflow(slave, termios.TCOOFF)
    assert ends_nothing(run, event, 2) in (0, 1)
    os.close(slave)
    os.close(master)


def lost(run, path):
    return [f["text"] for f in run.host.report()["faults"]
            if f["name"] in ("file_incomplete", "records_lost") and path in f["text"]]


def test_reader_gone(start, tmp_path):
    fifo = str(tmp_path / "trace.fifo")
    os.mkfifo(fifo)
    reading = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    run = start("--trace", fifo)
    event = run.bus.mark()
    os.close(reading)
    assert ends_nothing(run, event, 2) == 1
    assert lost(run, fifo)


def test_nobody_reads(start, tmp_path):
    fifo = str(tmp_path / "trace.fifo")
    os.mkfifo(fifo)
    run = start("--trace", fifo)
    assert ends_nothing(run, run.bus.mark()) == 1
    assert re.search(r"lacks \d+ lines", lost(run, fifo)[0])


def test_file_size_limit(start, tmp_path):
    trace = str(tmp_path / "trace.csv")
    run = start("--trace", trace, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000)))
    assert ends_nothing(run, run.bus.mark(), 3) == 1
    assert "File too large" in (run.host.report_path.read_text())


def test_fault_of_the_rig(start, rig):
    if not rig.is_simulated:
        pytest.skip("plays a fault")
    run = start()
    event = run.now()
    rig.fault("emcy bus=can0 node=1 value=0x5000")
    time.sleep(1)
    run.expect_zero("fault of the rig", event)
    assert run.end() == 1
    run.expect_last_frames(event[0])
    text = run.host.error_text()
    assert re.search(r"at \d+\.\d+ s: FAULT emergency \(can0 node 1, encoder of turret, code 0x5000\)", text)
    fault = next(e for e in run.host.report()["events"] if e["event"] == "fault")
    assert (fault["name"], fault["bus"], fault["node"]) == ("emergency", "can0", 1)
    assert fault["cause"] and fault["remedy"] and fault["t_s"] > 0


def test_rearming_is_told(start, rig):
    if not rig.is_simulated:
        pytest.skip("plays a fault")
    run = start("--rearm", "auto")
    mark = run.bus.mark()
    rig.fault("emcy bus=can0 node=1 value=0x5000")

    def told():
        return [word for _, text in run.host.console()
                for word in re.findall("^(FAULT emergency|the device is lost|ARMED again)", text)]

    hil.wait_for(lambda: "ARMED again" in told(), 10, "the host arms again")
    run.bus.wait_for(lambda f: f.kind == hil.RPDO1 and f.target_per_mille != 0, 5, "torque", mark)
    assert told()[:3] == ["FAULT emergency", "the device is lost", "ARMED again"]
    run.end()
    assert {"fault", "lost", "armed"} <= {event["event"] for event in run.host.report()["events"]}
