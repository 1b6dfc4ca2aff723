"""NMT and CiA 402 state machines on the wire, from power-up to shut-down."""
import godobject_hil as hil

ENCODERS, DRIVES = (1, 2), (11, 12)
TO_ENABLED = ["switch on disabled", "ready to switch on", "switched on", "operation enabled"]


def without_repeats(values):
    return [v for i, v in enumerate(values) if i == 0 or v != values[i - 1]]


def test_host_starts_every_node(host, outsider):
    started = {f.node for f in outsider.since(0, kind=hil.NMT) if f.nmt_command == "start"}
    assert started >= set(ENCODERS + DRIVES) or 0 in started
    for node in ENCODERS + DRIVES:
        outsider.wait_for(lambda f: f.kind == hil.HEARTBEAT and f.node == node and f.nmt_state == "operational", 5,
                          f"heartbeat of node {node} in operational")


def test_drives_are_enabled_step_by_step_and_without_torque(host, outsider):
    for node in DRIVES:
        states = without_repeats([f.drive_state for f in outsider.since(0, kind=hil.TPDO1, node=node)])
        assert states[:len(TO_ENABLED)] == TO_ENABLED
        for frame in outsider.since(0, kind=hil.TPDO1, node=node):
            if frame.drive_state == "operation enabled":
                break
            assert frame.actual_per_mille == 0
        enabling = [f for f in outsider.since(0, kind=hil.RPDO1, node=node) if f.controlword != 0x0F]
        assert all(f.target_per_mille == 0 for f in enabling)


def test_shutdown_leaves_motors_at_zero_and_nodes_pre_operational(host, outsider, rig):
    mark = outsider.mark()
    assert host.stop() is not None, "godobject run did not end by itself"
    for node in DRIVES:
        last = outsider.since(mark, kind=hil.RPDO1, node=node)[-1]
        assert (last.controlword, last.target_per_mille) == (0, 0)
    for node in ENCODERS + DRIVES:
        outsider.wait_for(
            lambda f: f.kind == hil.HEARTBEAT and f.node == node and f.nmt_state == "pre-operational", 5,
            f"node {node} pre-operational", mark)
    if rig.simulator:
        hil.wait_for(lambda: rig.simulator.torque_Nm() == 0, 1, "motors at zero")


def test_killed_host_leaves_motors_at_zero(host, outsider, simulator):
    host.popen.kill()
    host.popen.wait()
    hil.wait_for(lambda: simulator.torque_Nm() == 0, 1, "motors at zero: the drives' own watchdog")
    emergency = outsider.wait_for(lambda f: f.kind == hil.EMCY and f.node in DRIVES, 5, "EMCY of a drive")
    assert emergency.emcy_code == 0x8250  # RPDO timeout (CiA 301); 8130h if it supervises the heartbeat


def test_second_host_takes_over(host, start_enabled):
    host.stop()
    start_enabled()
