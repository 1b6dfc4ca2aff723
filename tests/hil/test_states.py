"""NMT and CiA 402 state machines on the wire, from power-up to shut-down."""
import pytest

from godobject import hil

pytestmark = pytest.mark.repeats_if_starved

ENCODERS, DRIVES = (1, 2), (11, 12)
TO_ENABLED = ["switch on disabled", "ready to switch on", "switched on", "operation enabled"]


def without_repeats(values):
    return [v for i, v in enumerate(values) if i == 0 or v != values[i - 1]]


def test_host_starts_every_node(run, bus):
    started = {f.node for f in bus.since(0, kind=hil.NMT) if f.nmt_command == "start"}
    assert started >= set(ENCODERS + DRIVES) or 0 in started
    for node in ENCODERS + DRIVES:
        bus.wait_for(lambda f: f.kind == hil.HEARTBEAT and f.node == node and f.nmt_state == "operational", 5,
                          f"heartbeat of node {node} in operational")


def test_drives_are_enabled_step_by_step_and_without_torque(run, bus):
    for node in DRIVES:
        states = without_repeats([f.drive_state for f in bus.since(0, kind=hil.TPDO1, node=node)])
        assert states[:len(TO_ENABLED)] == TO_ENABLED
        for frame in bus.since(0, kind=hil.TPDO1, node=node):
            if frame.drive_state == "operation enabled":
                break
            assert frame.actual_per_mille == 0
        enabling = [f for f in bus.since(0, kind=hil.RPDO1, node=node) if f.controlword != 0x0F]
        assert all(f.target_per_mille == 0 for f in enabling)


def test_shutdown_leaves_motors_at_zero_and_nodes_pre_operational(run, bus, rig):
    mark = bus.mark()
    assert run.stop() is not None, "godobject run did not end by itself"
    for node in DRIVES:
        last = bus.since(mark, kind=hil.RPDO1, node=node)[-1]
        assert (last.controlword, last.target_per_mille) == (0, 0)
    for node in ENCODERS + DRIVES:
        bus.wait_for(
            lambda f: f.kind == hil.HEARTBEAT and f.node == node and f.nmt_state == "pre-operational", 5,
            f"node {node} pre-operational", mark)
    if rig.is_simulated:
        rig.wait_for_zero_torque(1)


@pytest.mark.simulated
def test_killed_host_leaves_motors_at_zero(run, bus, rig):
    run.kill()
    rig.wait_for_zero_torque(1)  # by the drives' own watchdog
    emergency = bus.wait_for(lambda f: f.kind == hil.EMCY and f.node in DRIVES, 5, "EMCY of a drive")
    assert emergency.emcy_code == 0x8250  # RPDO timeout (CiA 301); 8130h if it supervises the heartbeat


def test_second_host_takes_over(run, rig):
    run.stop()
    rig.run_enabled()
