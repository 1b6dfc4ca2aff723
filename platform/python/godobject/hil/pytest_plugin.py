"""pytest with godobject.hil: `-p godobject.hil.pytest_plugin`, or pytest_plugins = ["godobject.hil.pytest_plugin"].

Fixtures: `rig` (Rig of the scene), `run` (`godobject run` on it with every drive enabled), `bus` (listener on its first
bus), `program`, `scene` and `motion` (paths; override them in a module), `tier`.
Markers: `scene_with(old, new)`: the scene with a text replaced, one marker for each. `vcan`: on vcan0, vcan1, ...;
skipped with the reason where there is no AF_CAN. `repeats_if_starved`: runs again, four times at most, if it failed
while a busy machine stalled the run. `simulated`: skipped on hardware, where nothing plays faults, before anything
starts.
A failed test shows the decoded frames around the failure and the standard error of each run.
"""
from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar, cast

import pytest
from _pytest.runner import runtestprotocol

from .clocks import now
from .errors import HilError, Late, NotAvailable
from .ports import Listener, why_no_socketcan
from .programs import Run
from .rig import ATTEMPTS, Rig
from .scene import Scene, changed_scene

_Hook = TypeVar("_Hook", bound=Callable[..., Any])


def _around(hook: _Hook) -> _Hook:
    return cast(_Hook, pytest.hookimpl(hookwrapper=True)(hook))


def _first(hook: _Hook) -> _Hook:
    return cast(_Hook, pytest.hookimpl(tryfirst=True)(hook))


_STARVED = pytest.StashKey[str]()
_REPEATED = pytest.StashKey[list[str]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("godobject")
    group.addoption("--program", default=os.environ.get("GODOBJECT_PROGRAM", shutil.which("godobject")),
                    help="godobject; default: $GODOBJECT_PROGRAM, else from PATH")
    group.addoption("--tier", choices=("pty", "vcan"), default="pty",
                    help="pty: SLCAN on pseudo-terminals; vcan: SocketCAN on vcan0, ..., which must be up")
    group.addoption("--hardware", metavar="INTERFACE", action="append", default=[],
                    help="a real rig on this SocketCAN interface, in place of the simulated one; NAME=INTERFACE for each of "
                         "several buses")
    group.addoption("--scene", help="that describes the rig; default: rig.toml beside the test")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "scene_with(old, new): the scene with this text replaced")
    config.addinivalue_line("markers", "vcan: runs on vcan0, ...; skipped with the reason without AF_CAN")
    config.addinivalue_line("markers", "simulated: skipped on hardware, where nothing plays faults")
    config.addinivalue_line("markers", "repeats_if_starved: repeated if it fails while a busy machine stalls the run")
    repeated: list[str] = []
    config.stash[_REPEATED] = repeated


def tier_of(config: pytest.Config) -> str:
    """Returns the name of the tier: pty, vcan or hardware INTERFACE."""
    hardware = config.getoption("--hardware")
    return f"hardware {' '.join(hardware)}" if hardware else str(config.getoption("--tier"))


def pytest_report_header(config: pytest.Config) -> str:
    return f"godobject: {config.getoption('--program')}, tier: {tier_of(config)}"


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    if report.when == "call":
        report.sections.append(("tier", str(dict(report.user_properties).get("tier", ""))))


@pytest.fixture(autouse=True)
def tier(request: pytest.FixtureRequest, record_property: Any) -> str:
    """Name of the tier, recorded in the report of the test."""
    name = "vcan" if request.node.get_closest_marker("vcan") else tier_of(request.config)
    record_property("tier", name)
    return name


@pytest.fixture
def program(request: pytest.FixtureRequest) -> str:
    """Path of godobject."""
    path = request.config.getoption("--program")
    if not path or not Path(path).exists():
        pytest.fail("no godobject: give --program, or build it")
    return str(path)


@pytest.fixture
def scene(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """Path of the scene: --scene, else rig.toml beside the test; changed by the marker scene_with."""
    path = str(request.config.getoption("--scene") or request.path.parent / "rig.toml")
    changes = [mark.args for mark in request.node.iter_markers("scene_with")]
    if not changes:
        return path
    folder = tmp_path / "scene"
    folder.mkdir()
    return changed_scene(path, folder, *changes)


@pytest.fixture
def motion() -> str | None:
    """Path of a CSV that the simulated hand follows; None: the scene's own motion."""
    return None


def _interfaces(described: Scene, hardware: list[str]) -> dict[str, str]:
    """Returns the interface of each bus of --hardware."""
    if len(hardware) == 1 and "=" not in hardware[0]:
        return {described.buses[0]: hardware[0]}
    return dict(text.partition("=")[::2] for text in hardware)


@pytest.fixture
def rig(request: pytest.FixtureRequest, program: str, scene: str, tier: str, motion: str | None,
        tmp_path: Path) -> Iterator[Rig]:
    """The rig of the scene, simulated or real."""
    described = Scene(scene, program)
    hardware = request.config.getoption("--hardware")
    buses: str | dict[str, str] = "pty"
    if request.node.get_closest_marker("vcan"):
        for i in range(len(described.buses)):
            if reason := why_no_socketcan(f"vcan{i}"):
                pytest.skip(reason)
        hardware = []
    if hardware and request.node.get_closest_marker("simulated"):
        pytest.skip("plays faults: only on a simulated rig")
    if hardware:
        buses = _interfaces(described, hardware)
    elif tier == "vcan":
        buses = "vcan"
    with Rig(described, buses=buses, simulated=not hardware, motion=motion, folder=tmp_path) as made:
        yield made
        made.end_programs()
        request.node.stash[_STARVED] = made.starved_by()
        if made.is_simulated:
            assert made.simulator.stop() == 0, made.simulator.error_text()


@pytest.fixture
def run(rig: Rig) -> Run:
    """`godobject run` with every drive enabled."""
    return rig.run_enabled()


@pytest.fixture
def pushing(rig: Rig, run: Run) -> Run:
    """`run`, once a drive has displayed torque."""
    rig.wait_for_torque()
    return run


@pytest.fixture
def bus(rig: Rig) -> Listener:
    """Listener on the first bus of the scene."""
    return rig.bus


@_around
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> Iterator[None]:
    """Skips a test that needs something which this machine, or a real rig, lacks."""
    outcome: Any = yield
    if outcome.excinfo and issubclass(outcome.excinfo[0], NotAvailable):
        reason = str(outcome.excinfo[1])
        try:
            pytest.skip(reason)
        except pytest.skip.Exception as skipped:
            outcome._excinfo = (type(skipped), skipped, skipped.__traceback__)


@_around
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Iterator[None]:
    """Adds the frames around a failure, and the texts of the runs."""
    outcome: Any = yield
    report: pytest.TestReport = outcome.get_result()
    if not report.failed or call.excinfo is None or report.when != "call":
        return
    for found in getattr(item, "funcargs", {}).values():
        if isinstance(found, Rig):
            late = call.excinfo.value if isinstance(call.excinfo.value, Late) else None
            around = late.moment_wall_s if late else now()
            report.sections.append((f"frames around {'the event' if late else 'the failure'}", found.frames_text(around)))
            for started in found.runs:
                report.sections.append((f"standard error of {started.name}", started.error_text()))
            if found.is_simulated and found.simulator.running:
                try:
                    report.sections.append(("faults of the rig", str(found.status()["faults"])))
                except HilError as error:
                    report.sections.append(("faults of the rig", str(error)))


@_first
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
    """Repeats a failed test of the marker repeats_if_starved if its run was stalled."""
    if item.get_closest_marker("repeats_if_starved") is None:
        return None
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for attempt in range(ATTEMPTS):
        item.stash[_STARVED] = ""
        reports = runtestprotocol(item, nextitem=nextitem, log=False)
        reason = item.stash[_STARVED]
        if not reason or attempt == ATTEMPTS - 1 or not any(report.failed for report in reports):
            break
        item.config.stash[_REPEATED].append(f"{item.nodeid}: {reason}")
    for report in reports:
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    for line in config.stash[_REPEATED]:
        terminalreporter.write_line(f"repeated, because a busy machine stalled the run: {line}")
