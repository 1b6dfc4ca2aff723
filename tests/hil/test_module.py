"""godobject.hil itself: decoded frames, clocks, expectations that fail, ends of programs, the pytest plugin."""
import json
import os
import re
import signal
import socket
import struct
import subprocess
import sys
from pathlib import Path

import pytest

from godobject import hil
from godobject.hil.pdo import values_of

pytestmark = pytest.mark.simulated

SOURCE = Path(__file__).parents[2]
MODULES = SOURCE / "platform" / "python"
DRIVES_ON_CAN1 = [('bus = "can0"\nnode_id = 11', 'bus = "can1"\nnode_id = 11'), ('bus = "can0"\nnode_id = 12', 'bus = "can1"\nnode_id = 12'),
                  ('[[bus]]\nname = "can0"', '[[bus]]\nname = "can0"\n\n[[bus]]\nname = "can1"')]
ODRIVES = ('profile = "patient-402"', 'protocol = "odrive"\nwatchdog = "drive"\nwatchdog_ms = 100')


def test_every_frame_has_the_name_that_the_program_gives_it(rig, run, program):
    rig.wait_for_torque()
    rig.wait_until(rig.status()["t_s"] + 0.3)  # heartbeats come every 0.1 s
    loads = subprocess.run([program, "bus-load", rig.scene.path, "--json"], capture_output=True, text=True).stdout
    expected = {message["name"] for message in json.loads(loads)[0]["messages"]}
    messages = [rig.scene.decode(f) for f in rig.bus.frames if f.kind not in (hil.OTHER, hil.NMT, hil.EMCY)]
    assert {message.name for message in messages} == expected
    assert all(message.values for message in messages if message.name != "SYNC")
    assert rig.value("state", "elbow") == "operation enabled"
    with pytest.raises(hil.HilError, match="no frame with axis_state.*\n.*its frames have .*state, statusword"):
        rig.value("axis_state", "elbow")  # of an ODrive
    units_are_those_of_the_scene(rig, run)


def units_are_those_of_the_scene(rig, run):
    command = rig.bus.wait_for(lambda f: f.kind == hil.RPDO1 and f.target_per_mille != 0, 5, "a torque")
    run.stop()  # nodes then answer no SYNC: the last positions, once they are read, are of one SYNC

    def difference_rad():  # an encoder's count is 0.4 mrad
        return abs(rig.value("position_rad", "elbow") - rig.value("position_rad", "elbow", "encoder"))

    hil.wait_for(lambda: difference_rad() < 1e-3, 5, "equal positions of drive and encoder")
    assert abs(rig.value("position_rad", "elbow")) < 0.31  # amplitude of the motion, rad
    assert rig.scene.decode(command).values["torque_Nm"] == pytest.approx(1e-4 * command.target_per_mille)
    with pytest.raises(hil.HilError, match="no drive of a joint 'wrist'.*\n.*turret, elbow"):
        rig.scene.node("wrist")


def test_clocks_agree(rig):
    run = rig.run_enabled(trace=True)
    rig.wait_for_torque()
    delays_s, first = [], hil.now()
    for _ in range(5):  # the smallest delay, since a busy machine delays the listener
        mark = rig.bus.mark()
        sent = rig.fault("emcy", joint="turret", value=0x5000)
        received = rig.bus.wait_for(lambda f: f.kind == hil.EMCY, 2, "the EMCY", mark)
        delays_s.append(received.time - sent.wall_s)
    # A wrong clock would be off by the age of a program, 0.5 s or more.
    assert -rig.clock.error_s <= min(delays_s) < 0.1, delays_s
    rig.wait_until(rig.status()["t_s"] + 0.2)
    run.stop()
    trace = hil.read_trace(run.trace_path)
    assert trace["t_bus"][0] == pytest.approx(run.clock().to_wall(0), abs=1e-4)
    record = [f.time for f in hil.read_candump(run.record_path) if f.kind == hil.SYNC and f.time >= trace["t_bus"][0] - 1e-3]
    heard = [f.time for f in rig.bus.since(kind=hil.SYNC) if f.time >= record[0] - 1e-3]
    assert min(abs(a - b) for a, b in zip(record, heard)) < rig.scene.step_s
    t_event_s, _ = run.wait_for_event("FAULT emergency", 1)
    assert first - rig.scene.step_s < run.clock().to_wall(t_event_s) < sent.wall_s + 0.1  # at the first of five EMCYs


@pytest.mark.repeats_if_starved
def test_an_expectation_of_zero_torque_can_fail(rig):
    with pytest.raises(hil.Expected, match="proves nothing"):
        rig.assert_zero_torque(after=hil.moment("nothing"), within_s=0.1, for_s=0)
    rig.run_enabled()
    rig.wait_for_torque()
    with pytest.raises(hil.Late, match="had torque for .* ms, permitted are 1.0 ms"):
        rig.assert_zero_torque(after=hil.moment("nothing"), within_s=0.001)


@pytest.mark.scene_with(*DRIVES_ON_CAN1[0])
@pytest.mark.scene_with(*DRIVES_ON_CAN1[1])
@pytest.mark.scene_with(*DRIVES_ON_CAN1[2])
@pytest.mark.scene_with(*ODRIVES)
@pytest.mark.repeats_if_starved
def test_two_buses_one_of_odrives(rig, run, program):
    rig.wait_for_torque()
    names = {name: {rig.scene.decode(f).name for f in listener.frames} for name, listener in rig.listeners.items()}
    loads = subprocess.run([program, "bus-load", rig.scene.path, "--json"], capture_output=True, text=True).stdout
    for bus in json.loads(loads):
        # Requests are remote frames, which a listener omits.
        assert {message["name"] for message in bus["messages"] if not message["name"].endswith("request")} <= names[bus["bus"]]
    assert rig.value("torque_Nm", "elbow") == pytest.approx(0, abs=0.1) and rig.value("axis_state", "elbow") == 8
    assert {f.kind for f in rig.listeners["can1"].frames} == {hil.OTHER}
    kinds = {(f.bus, f.kind) for f in hil.read_candump(run.record_path, rig.scene)}
    assert ("can0", hil.SYNC) in kinds and {kind for bus, kind in kinds if bus == "can1"} == {hil.OTHER}
    cut = rig.fault("unplug", bus="can1")
    rig.assert_zero_torque(after=cut, within_s=0.1 + 5 * rig.scene.step_s)  # watchdog_ms
    run.wait_for_event(r"FAULT drive_silent \(can1 node 11", 1)


OF_DRIVES = """
[[pdo]]
pdo = "tpdo3"
transmission = 1
map = ["torque", "velocity", "6061h:00:8"]
"""
OF_ENCODERS = """
[[pdo]]
pdo = "tpdo1"
transmission = 1
map = ["encoder_position"]
[[pdo]]
pdo = "tpdo2"
transmission = 1
map = ["encoder_speed", "encoder_position"]
"""


@pytest.mark.scene_with("offset_counts = 8192", 'profile = "more-406"\noffset_counts = 8192')
@pytest.mark.repeats_if_starved
def test_each_pdo_of_a_profile_has_the_values_of_its_map(program, scene, tmp_path):
    profile = Path(scene).with_name("patient-402.toml")
    profile.write_text(profile.read_text() + OF_DRIVES)
    Path(scene).with_name("more-406.toml").write_text(OF_ENCODERS)
    with hil.Rig(scene, program=program, folder=tmp_path) as rig:
        run = rig.run_enabled()
        rig.wait_for_torque()
        of_drive = rig.bus.wait_for(lambda f: f.kind == hil.TPDO3 and f.node == 11, 2, "TPDO3 of a drive")
        of_encoder = rig.bus.wait_for(lambda f: f.kind == hil.TPDO2 and f.node == 2, 2, "TPDO2 of an encoder")
        torque, velocity, mode = struct.unpack("<hib", of_drive.data)
        speed, counts = struct.unpack("<hI", of_encoder.data)
        turret = rig.scene.node("turret")
        assert rig.scene.decode(of_drive).values == {"torque_Nm": pytest.approx(1e-4 * torque), "mode": 10,
                                                     "velocity_rad_per_s": pytest.approx(velocity / turret.counts_per_unit)}
        assert mode == 10 and rig.decode(of_drive).startswith("can0 38B turret drive tpdo3")
        of_maker = values_of(turret, hil.TPDO4, ((0x2111, 2, 32), (0x60FD, 0, 8)), b"\x04\x03\x02\x01\xff")
        assert of_maker == {"2111h:02": 0x01020304, "digital_inputs": 255}
        # The host reads a maker's object in the place of the standard position as the position.
        status = ((0x6041, 0, 16), (0x2111, 2, 32), (0x6077, 0, 16))
        assert values_of(turret, hil.TPDO1, status, struct.pack("<Hih", 0, -7, 1))["position_counts"] == -7
        assert not values_of(turret, hil.TPDO1, None, bytes(7))
        elbow = rig.scene.node("elbow", "encoder")
        assert rig.scene.decode(of_encoder).values == {"speed": speed, "position_counts": counts,
                                                       "position_rad": elbow.position(counts)}
        run.stop()
        loads = subprocess.run([program, "bus-load", scene, "--json"], capture_output=True, text=True).stdout
        expected = {message["name"] for message in json.loads(loads)[0]["messages"]}
        names = {rig.scene.decode(f).name for f in rig.bus.frames if f.kind not in (hil.OTHER, hil.NMT, hil.EMCY)}
        assert {"button node 21 inputs", "button node 21 heartbeat"} <= expected <= names
        assert names - expected == {f"{joint} {pdo}" for joint in ("turret", "elbow")
                                    for pdo in ("drive tpdo3", "encoder tpdo2")}


def test_every_verb_is_accepted(rig, program):
    listed = (SOURCE / "docs/faults.md").read_text().partition("<!-- fault verbs: begin -->")[2].partition("<!-- fault verbs: end")[0]
    verbs = re.findall(r"^- `([\w-]+)` \(([^;)]*)", listed, re.M)
    assert len(verbs) > 15
    for verb, places in verbs:
        if verb == "press":
            rig.fault(verb, bus="can0", node=21)
        elif "node" in places and "tool" not in places:
            rig.fault(verb, joint="turret")
        elif "bus" in places:
            rig.fault(verb, bus="can0")
    with hil.Rig(SOURCE / "sim/scenes/tracked.toml", program=program) as tracked:
        for verb, places in verbs:
            if "tracker" in places:
                tracked.fault(verb, tracker=tracked.scene.trackers[0])
        tracked.clear()
        tracked.start_run()
        hil.wait_for(lambda: tracked.status()["trackers"][0]["bytes_from_host"] > 0, 20, "a run that reads the tracker")
    with pytest.raises(hil.Refused, match="unknown verb"):
        rig.fault("dorp", bus="can0")
    with pytest.raises(hil.Refused, match="--nosuch"):
        rig.run_enabled("--nosuch")


def test_the_example_of_the_page_runs(program):
    example = re.search(r"```python\n(.*?)```", (SOURCE / "docs/python-hil.md").read_text(), re.S)[1]
    done = subprocess.run([sys.executable, "-c", example], capture_output=True, text=True, cwd=SOURCE, timeout=60,
                          env=dict(os.environ, PYTHONPATH=str(MODULES), GODOBJECT_PROGRAM=program))
    assert done.returncode == 0 and "FAULT sample_stale (can0 node 1, encoder of turret)" in done.stdout, done.stderr


def test_frames_of_socketcan(monkeypatch):
    class Socket(socket.socket):  # in place of one of AF_CAN, which few machines have
        def bind(self, address):
            assert address == ("can0",)

    near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
    near = Socket(fileno=near.detach())
    monkeypatch.setattr("godobject.hil.ports.why_no_socketcan", lambda interface: "")
    monkeypatch.setattr(socket, "socket", lambda *kind: near)
    port = hil.SocketCanPort("can0")
    standard, extended, remote = 0x18B, 0x1ABCDEF0 | 1 << 31, 0x181 | 1 << 30
    before = hil.now()
    for can_id, data in ((standard, b"\x37\x12"), (remote, b""), (extended, bytes(8))):
        far.send(struct.pack("=IB3x8s", can_id, len(data), data))
    received = [frame for _ in range(3) for frame in port.receive(1)]
    assert [frame[1:] for frame in received] == [(0x18B, b"\x37\x12", False), (0x1ABCDEF0, bytes(8), True)]
    assert all(before - 0.01 <= frame[0] <= hil.now() + 0.01 for frame in received)
    port.send(0x20B, b"\x0f\x00\x01\x00")
    assert far.recv(99) == struct.pack("=IB3x8s", 0x20B, 4, b"\x0f\x00\x01\x00")
    assert port.receive(0) == []


def test_a_log_with_a_wrong_line_is_refused(tmp_path):
    log = tmp_path / "bus.log"
    log.write_text("(1.5) can0 18B#3712000000000000\n(1.6) can0 181#R4\n(1.7) can1 1ABCDEF0#01 R\n(1.8) can0 08")
    frames = list(hil.read_candump(log))
    assert [(f.time, f.bus, f.id, f.kind, f.node) for f in frames] == [
        (1.5, "can0", 0x18B, hil.TPDO1, 11), (1.7, "can1", 0x1ABCDEF0, hil.OTHER, 0)]
    assert frames[0].drive_state == "operation enabled"
    with pytest.raises(hil.HilError, match="8 bytes|1 bytes"):
        hil.make_frame(0, "can0", 0x18B, b"1").statusword
    log.write_text("(1.5) can0 18B#371\n(1.6) can0 181#00\n")
    with pytest.raises(hil.HilError, match="bus.log:1: no frame"):
        list(hil.read_candump(log))


def test_a_scene_with_an_error_is_refused_with_its_line(rig, tmp_path, program):
    path = hil.changed_scene(rig.scene.path, tmp_path, ("counts_per_turn = 16384", "counts_per_tun = 16384"))
    with pytest.raises(hil.Refused, match=r"rig.toml:\d+:\d+.*counts_per_tun"):
        hil.Rig(path, program=program)


def test_buses_that_are_not_there_are_refused(scene, program):
    with pytest.raises(hil.NotAvailable, match="socketcan:none0: (this machine has no AF_CAN|no interface none0)"):
        hil.Rig(scene, program=program, buses={"can0": "none0"}, simulated=False)
    with pytest.raises(hil.HilError, match=r"rig.toml: buses without an interface: \['can0'\], unknown ones: \['can7'\]"):
        hil.Rig(scene, program=program, buses={"can7": "vcan0"})
    with pytest.raises(hil.HilError, match="no kind of buses 'slcan'"):
        hil.Rig(scene, program=program, buses="slcan")
    with pytest.raises(hil.NotAvailable, match="exit code 3|none0"):
        hil.Rig(scene, program=program, buses={"can0": "none0"})


def test_programs_end_with_an_exception(scene, program):
    with pytest.raises(ZeroDivisionError), hil.Rig(scene, program=program) as rig:
        run = rig.start_run()
        own = rig.start(["sleep", "60"])
        1 / 0
    assert not run.running and not own.running and not rig.simulator.running


def test_programs_end_with_a_killed_python(scene, program):
    code = ("from godobject import hil; import time\n"
            f"rig = hil.Rig({scene!r}, program={program!r}); run = rig.run_enabled()\n"
            "print(rig.simulator.popen.pid, run.popen.pid, flush=True); time.sleep(60)")
    with hil.Process([sys.executable, "-c", code], stdout=subprocess.PIPE,
                     env=dict(os.environ, PYTHONPATH=str(MODULES))) as killed:
        pids = [int(pid) for pid in killed.popen.stdout.readline().split()]
        killed.kill()
    assert len(pids) == 2, killed.error_text()

    def gone(pid):
        try:
            return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
        except OSError:
            return True

    hil.wait_for(lambda: all(map(gone, pids)), 10, "the end of both programs")


PLUGIN_TEST = """
import pytest
from godobject import hil
tries = []

def test_fails(rig, run):
    rig.wait_for_torque()
    rig.assert_zero_torque(after=hil.moment("nothing"), within_s=0.001, for_s=0.1)

@pytest.mark.repeats_if_starved
def test_stalls_once(rig, run):
    tries.append(1)
    if len(tries) == 1:
        run.pause(0.06)  # six periods
    assert len(tries) == 2

@pytest.mark.vcan
def test_on_vcan(rig, run):
    assert rig.address() == "socketcan:vcan0"

@pytest.mark.simulated
def test_is_skipped_on_hardware(rig):
    assert rig.is_simulated
"""


def test_the_plugin_reports_frames_and_repeats(tmp_path, scene, program):
    (tmp_path / "test_it.py").write_text(PLUGIN_TEST)
    command = [sys.executable, "-m", "pytest", "-p", "godobject.hil.pytest_plugin", "-p", "no:cacheprovider", "-rs", tmp_path,
               "--program", program, "--scene", scene]
    environment = dict(os.environ, PYTHONPATH=str(MODULES), PYTHONDONTWRITEBYTECODE="1")
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=100)
    text = done.stdout + done.stderr
    has_vcan = not hil.why_no_socketcan("vcan0")
    assert re.search(rf"1 failed, {3 if has_vcan else 2} passed", text), text
    assert has_vcan or re.search(r"SKIPPED.*(no AF_CAN|no interface vcan0|is down)", text), text
    assert "frames around the event" in text and re.search(r"ms  can0 18C elbow drive status +statusword 0x1237, state", text), text
    assert "repeated, because a busy machine stalled the run" in text and "test_stalls_once" in text, text
    on_hardware = subprocess.run([*command, "--hardware", "none0", "-k", "skipped"], capture_output=True, text=True,
                                 env=environment, timeout=100).stdout
    assert re.search(r"SKIPPED.*only on a simulated rig", on_hardware), on_hardware


def test_the_example_of_the_readme_is_a_test(tmp_path, scene, program):
    example = re.search(r"```python\n(.*?)```", (SOURCE / "README.md").read_text(), re.S)[1]
    (tmp_path / "test_it.py").write_text(example)
    command = [sys.executable, "-m", "pytest", "-p", "godobject.hil.pytest_plugin", "-p", "no:cacheprovider", tmp_path,
               "--program", program, "--scene", scene]
    environment = dict(os.environ, PYTHONPATH=str(MODULES), PYTHONDONTWRITEBYTECODE="1")
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=100)
    assert "1 passed" in done.stdout, done.stdout + done.stderr


def test_types_are_complete(tmp_path):
    pytest.importorskip("mypy", reason="no mypy: apt-get install mypy")
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path, MODULES / "godobject"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_signals_go_to_own_programs_alone():
    with hil.Process([sys.executable, "-c", "import time; time.sleep(60)"]) as own:
        sent = own.send_signal(signal.SIGTERM)
        assert own.wait() == -signal.SIGTERM and "SIGTERM" in sent.text
    with pytest.raises(hil.Ended, match="/no/such: No such file"):
        hil.Process(["/no/such"])
