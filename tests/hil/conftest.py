"""Fixtures: a rig, its host and an outsider on one bus, selected by --tier or --hardware; see README.md."""
import os
import shutil
from pathlib import Path
from types import SimpleNamespace

import can
import pytest

import godobject_hil as hil
from slcan_bus import SlcanBus

HERE = Path(__file__).parent
BUS = "can0"  # name in the scene
ATTEMPTS = 4  # limit of repeats after a busy machine has stalled the host


def pytest_addoption(parser):
    group = parser.getgroup("godobject")
    group.addoption("--program", default=os.environ.get("GODOBJECT_PROGRAM", shutil.which("godobject")),
                    help="godobject; default: $GODOBJECT_PROGRAM, else from PATH")
    group.addoption("--tier", choices=("pty", "vcan"), default="pty",
                    help="pty: SLCAN on pseudo-terminals; vcan: SocketCAN on vcan0, which must be up")
    group.addoption("--hardware", metavar="INTERFACE",
                    help="a real rig on this SocketCAN interface, in place of the simulated one")
    group.addoption("--scene", default=str(HERE / "rig.toml"), help="that describes the rig")


@pytest.hookimpl(trylast=True)  # after -k has selected
def pytest_collection_modifyitems(items):
    """Every k-th test where k, GTEST_TOTAL_SHARDS, is in the environment, as in `./dev test`."""
    items[:] = items[::int(os.environ.get("GTEST_TOTAL_SHARDS", "1"))]


def tier_of(config):
    hardware = config.getoption("--hardware")
    return f"hardware {hardware}" if hardware else config.getoption("--tier")


def pytest_report_header(config):
    return f"godobject: {config.getoption('--program')}, tier: {tier_of(config)}"


def pytest_runtest_logreport(report):
    if report.when == "call":
        report.sections.append(("tier", dict(report.user_properties).get("tier", "")))


@pytest.fixture(autouse=True)
def tier(request, record_property):
    """Name of the tier, recorded in the report of the test."""
    name = tier_of(request.config)
    record_property("tier", name)
    return name


@pytest.fixture
def program(request):
    path = request.config.getoption("--program")
    if not path or not Path(path).exists():
        pytest.fail("no godobject: give --program, or build it")
    return path


@pytest.fixture
def scene(request):
    return request.config.getoption("--scene")


@pytest.fixture
def motion():
    """Path of a CSV that the simulated hand follows; None: the scene's own motion. Tests override it."""
    return None


def start_simulated(program, scene, tier, motion):
    """Starts the simulator. Returns it, the address for the host, and the outsider's bus."""
    arguments = ["--motion", motion] if motion else []
    if tier == "pty":
        simulator = hil.Simulator(program, scene, ["--realtime", "--bus", "pty", "--tap", "pty", *arguments])
        address = "slcan:" + simulator.buses[BUS]
        outside = SlcanBus(simulator.taps[BUS])
    else:
        # Not --realtime, otherwise the outsider gets no time in a guest with one processor.
        simulator = hil.Simulator(program, scene, ["--bus", f"{BUS}=socketcan:vcan0", *arguments])
        address = "socketcan:vcan0"
        outside = can.Bus(interface="socketcan", channel="vcan0")
    return simulator, address, outside


@pytest.fixture
def rig(request, program, scene, tier, motion):
    """The rig and an outsider on its bus: simulator (None on hardware), outsider, address for the host."""
    hardware = request.config.getoption("--hardware")
    if hardware:
        simulator, address = None, f"socketcan:{hardware}"
        outside = can.Bus(interface="socketcan", channel=hardware)
    else:
        simulator, address, outside = start_simulated(program, scene, tier, motion)
    outsider = hil.Outsider(outside)
    yield SimpleNamespace(simulator=simulator, outsider=outsider, address=f"{BUS}={address}")
    outsider.close()
    if simulator:
        assert simulator.stop() == 0, simulator.error_text()


@pytest.fixture
def simulator(rig):
    """Simulator for tests that inject faults; they are skipped on hardware."""
    if rig.simulator is None:
        pytest.skip("plays faults: only on a simulated rig")
    return rig.simulator


@pytest.fixture
def outsider(rig):
    return rig.outsider


@pytest.fixture
def start_host(rig, program, scene, tmp_path):
    """Starts `godobject run`; stops it at the end of the test if it still runs."""
    hosts = []

    def start(*arguments):
        hosts.append(hil.Host(program, scene, [rig.address], tmp_path, arguments))
        return hosts[-1]

    yield start
    for host in hosts:
        host.stop()


@pytest.fixture
def start_enabled(start_host, outsider):
    """Starts `godobject run` and waits for its drives to be enabled."""
    def start():
        for _ in range(ATTEMPTS):
            mark = outsider.mark()
            host = start_host()
            if became_enabled(outsider, host, mark):
                return host
            assert hil.was_starved(host), f"godobject run has ended:\n{host.error_text()}\n{host.fault_text()}"
        pytest.fail(f"godobject run ended {ATTEMPTS} times:\n{host.fault_text()}")

    return start


@pytest.fixture
def host(start_enabled):
    """`godobject run` with every drive enabled."""
    return start_enabled()


def became_enabled(outsider, host, mark, timeout_s=15):
    """Waits for both drives; returns False if the host ended by itself."""
    def enabled():
        drives = {f.node: f.drive_state for f in outsider.since(mark, kind=hil.TPDO1) if len(f.data) == 8}
        return len(drives) == 2 and set(drives.values()) == {"operation enabled"}

    hil.wait_for(lambda: enabled() or not host.running(), timeout_s, "both drives in operation enabled")
    return host.running()
