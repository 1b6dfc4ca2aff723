"""Eight tests that a newcomer writes first, on rig.toml, with the public module alone.

Times are measured on the rig's clock, where late wake-ups of pytest do not count. Late wake-ups of the host do: such a
test is repeated if the run has missed deadlines.
"""
import pytest

from godobject import hil

pytestmark = [pytest.mark.simulated, pytest.mark.repeats_if_starved]

WATCHDOG_S = 0.1  # deadline_ms of patient-402.toml
CYCLES = 5  # to detect, command and transmit; see the promises in docs/faults.md


def within(rig, detected_s):
    """Returns the permitted time to zero torque, s: detection, ramp, cycles."""
    return detected_s + rig.scene.ramp_s + CYCLES * rig.scene.step_s


def test_unplug(rig, pushing):
    rig.assert_zero_torque(after=rig.fault("unplug", joint="elbow"), within_s=within(rig, rig.scene.loss_s))
    pushing.wait_for_event(r"FAULT sample_stale \(can0 node 2, encoder of elbow\)", 1)


def test_rearm(rig):
    run = rig.run_enabled("--rearm", "auto")
    rig.wait_for_torque()
    rig.fault("emcy", joint="turret", value=0x5000)
    rig.wait_for_zero_torque(1)
    armed_s, _ = run.wait_for_event("ARMED again", 10)
    rig.wait_for_torque()
    assert armed_s > run.console()[0][0]


@pytest.mark.scene_with("torque_max_Nm = 0.1", "torque_max_Nm = 0.001")
@pytest.mark.scene_with("mass = 0.1", "mass = 0.5")  # otherwise the hand feels less than this
def test_limits(rig, run):
    limit_Nm = rig.scene.node("turret").torque_max_Nm
    rig.wait_for_torque(0.99 * limit_Nm)
    run.stop()
    assert max(abs(rig.scene.decode(f).values["torque_Nm"]) for f in rig.bus.since(kind=hil.RPDO1)) == pytest.approx(limit_Nm)
    assert run.report()["limits"]["drive_torque"] > 0


def test_stale(rig, pushing):
    rig.fault("drop", joint="elbow", duration=rig.scene.loss_s / 2)  # bridged
    rig.wait_until(rig.status()["t_s"] + rig.scene.loss_s)
    assert pushing.running and not pushing.console()
    rig.assert_zero_torque(after=rig.fault("drop", joint="elbow"), within_s=within(rig, rig.scene.loss_s))
    pushing.wait_for_event("FAULT sample_stale", 1)


def test_swapped_ids(rig, pushing):
    rig.fault("swap-ids", joint="turret", value=rig.scene.node("elbow", "encoder").node_id)
    pushing.wait_for_event("FAULT (sensors_disagree|sample_implausible).* of (turret|elbow)", 3)
    rig.wait_for_zero_torque(within(rig, 0) + 1)


def test_watchdog(rig, pushing):
    rig.assert_zero_torque(after=pushing.kill(), within_s=WATCHDOG_S + CYCLES * rig.scene.step_s)
    assert rig.bus.wait_for(lambda f: f.kind == hil.EMCY and f.node in (11, 12), 1, "EMCY of a drive").emcy_code == 0x8250


def test_hiccup(rig, run):
    run.pause(3 * rig.scene.step_s)
    rig.wait_for_torque()
    assert run.stop() == 0 and run.missed_deadlines() > 0


def test_double_host(rig, pushing):
    rig.assert_zero_torque(after=rig.bus.send(0x080), within_s=within(rig, 0.05))
    pushing.wait_for_event("FAULT second_host", 1)
