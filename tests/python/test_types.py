"""A program of a user against the types of the package, as mypy --strict sees them."""
import os
import subprocess
import sys
from pathlib import Path

import pytest

MODULES = Path(__file__).resolve().parents[2] / "platform/python"

PROGRAM = '''
from __future__ import annotations
import pathlib
import numpy as np
from godobject import FaultError, Scene, SceneError, hil, read_recording, read_report, read_trace
from godobject.device import Device, Pose, Wrench
from godobject.world import Plane, World

def unplugged(rig: hil.Rig, run: hil.Run) -> float:
    rig.wait_for_torque()
    moment: hil.Moment = rig.fault("unplug", joint="turret")
    took_s: float = rig.assert_zero_torque(after=moment, within_s=0.02)
    torques: list[float] = [abs(rig.scene.decode(f).values["torque_Nm"]) for f in rig.bus.since(kind=hil.RPDO1)]
    slip: float = rig.value("position_rad", "turret") - rig.value("position_rad", "turret", "encoder")
    state: str = rig.value("state", "turret")
    t_s, text = run.wait_for_event("FAULT", 1)
    return took_s + max(torques) + slip + rig.clock.to_wall(t_s) + len(state + text)

def swept(path: pathlib.Path) -> None:
    scene = Scene(path)
    rows = scene.run(duration=2.0)
    print(float(np.linalg.norm(rows.feedback_wrenches[:, 0, :3], axis=1).max()), scene.run(every=10).positions.shape)
    print(scene.bodies[0].upper(), scene.t + 1, scene.positions[0].tolist(), scene.contacts.forces.sum(), scene.contacts.on)
    try:
        Scene.from_dict({"scene": {"name": "a"}})
    except SceneError as error:
        line: int | None = error.line
        print(error.file.upper(), line, error.problems[0].key)
    except FaultError as fault:
        print(fault.faults[0].upper(), fault.t + 1)
    trace = read_trace(path)
    print(trace["t"].max(), trace.positions("peg").shape, read_recording("a.log")["t_ns"], read_report("r.json")["faults"])

class Mine(Device):
    def read(self) -> Pose:
        return Pose(p_m=(0.0, 0.0, 0.1), t_s=1.5)
    def show(self, wrench: Wrench) -> None:
        print(wrench.f_N[0] + 1)

def surrounded() -> None:
    with World("w") as world:
        while (tool := world.wait(60)) is not None:
            world.write([Plane(1, p_m=tool.positions[0], n=(1, 0, 0))])
'''
WRONG = PROGRAM + '''
Scene("a").positions = 1
hil.Rig(3)
Scene("a").run(every=0).t
Mine().run(5)
'''


@pytest.fixture(scope="module")
def errors_of(tmp_path_factory):
    pytest.importorskip("mypy", reason="no mypy: apt-get install mypy")

    folder = tmp_path_factory.mktemp("typed")

    def check(text):
        (folder / "program.py").write_text(text)
        done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", folder / "cache", "program.py"],
                              cwd=folder, env=dict(os.environ, MYPYPATH=str(MODULES)), capture_output=True, text=True)
        return [line for line in done.stdout.splitlines() if ": error: " in line]

    return check


def test_a_typed_program_has_no_errors(errors_of):
    assert errors_of(PROGRAM) == []


def test_wrong_types_are_errors(errors_of):
    errors = errors_of(WRONG)
    first = PROGRAM.count("\n") + 2
    assert {int(error.split(":")[1]) for error in errors} == set(range(first, first + 4)), errors
