"""Every fault verb and its documented reaction, docs/faults.md."""
import pytest

import godobject_hil as hil
from conftest import ATTEMPTS

# What is played, and which faults the run must name: one of them at least; none where the rig rides it out.
REACTIONS = [
    ("drop bus=can0 node=1 value=0.02", set()),
    ("drop bus=can0 node=1 duration=1", {"sample_stale"}),
    ("drop bus=can0 node=11 duration=1", {"drive_silent"}),
    ("duplicate bus=can0", set()),
    ("delay bus=can0 node=1 value=1e-3", set()),
    ("delay bus=can0 value=0.2 duration=1", {"sample_stale", "drive_silent"}),
    ("corrupt bus=can0 value=0.02", set()),
    ("corrupt bus=can0 node=1 value=1 duration=1", {"sample_stale"}),
    ("stuck bus=can0 node=1", set()),
    ("spike bus=can0 node=1", set()),
    ("spike bus=can0 node=1 duration=1", {"sample_implausible"}),
    ("wrap bus=can0 node=1", {"sample_implausible"}),
    ("nan bus=can0 node=1 duration=1", {"sample_implausible"}),
    ("reboot-node bus=can0 node=1", {"node_restarted"}),
    ("reboot-node bus=can0 node=11 duration=0.5", {"drive_silent"}),
    ("emcy bus=can0 node=1 value=0x5000", {"emergency"}),
    ("emcy bus=can0 node=11", {"emergency", "drive_not_enabled"}),
    ("bus-off bus=can0 node=1", {"sample_stale"}),
    ("bus-off bus=can0", {"sample_stale", "drive_silent", "bus_down"}),
    ("restart bus=can0", set()),
    ("unplug bus=can0 node=2", {"sample_stale"}),
    ("unplug bus=can0", {"sample_stale", "drive_silent"}),
    ("id-collision bus=can0 node=1", {"node_restarted", "sample_stale"}),
    ("clock-drift bus=can0 node=1", set()),
    ("clock-drift bus=can0 node=2 value=-9e5", {"heartbeat_lost"}),
]
# stale_after of rig.toml, or the drive's own watchdog, and the run-down; a loaded machine may take some more.
ZERO_WITHIN_S = 0.5
QUIET_S = 0.3  # with no torque for so long it is not just passing through zero


@pytest.mark.parametrize("words, expected", REACTIONS, ids=[words.replace(" ", "-") for words, _ in REACTIONS])
def test_fault_has_its_documented_reaction(words, expected, start_enabled, simulator):
    for _ in range(ATTEMPTS):
        host = start_enabled()
        zero_after_s = play(words, expected, simulator) if pulls(simulator) else None
        assert host.stop() is not None, "godobject run did not end by itself"
        simulator.clear()
        as_documented = host.faults() & expected if expected else not host.faults()
        if as_documented and zero_after_s is not None:
            break
        assert hil.was_starved(host), host.fault_text()
    else:
        pytest.fail(f"{ATTEMPTS} times: {host.fault_text()}")
    if expected and "heartbeat_lost" not in expected:  # that one takes its time-out
        assert zero_after_s < ZERO_WITHIN_S


def pulls(simulator):
    """Whether there is torque, which the fault is to take away."""
    try:
        return hil.wait_for(lambda: simulator.torque_Nm() > 0, 5, "torque before the fault")
    except hil.TimedOut:
        return False


def play(words, expected, simulator):
    """The time from the fault to the last torque, where there is to be a reaction."""
    started = simulator.fault(words)["t_s"]
    if not expected:
        hil.wait_for(lambda: simulator.status()["t_s"] > started + 1, 5, "a second")
        return 0

    def quiet():
        status = simulator.status()
        return status if status["t_s"] - last_torque_s(status) > QUIET_S else None

    return last_torque_s(hil.wait_for(quiet, 10, "motors at zero")) - started


def last_torque_s(status):
    return max(drive["nonzero_at_s"] for drive in status["drives"])


def test_unknown_fault_is_refused(simulator):
    with pytest.raises(AssertionError, match="no verb"):
        simulator.fault("dorp bus=can0")
