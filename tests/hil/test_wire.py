"""The bus as an outsider sees it while the rig works: order and timing of frames, sense of the torque, record."""
from collections import Counter
from statistics import median

import pytest

import godobject_hil as hil

PERIOD_S = 2e-3  # of rig.toml
ENCODERS, DRIVES = (1, 2), (11, 12)


def cycles_of(frames):
    """Lists of frames that begin with a SYNC."""
    cycles = []
    for frame in frames:
        if frame.kind == hil.SYNC:
            cycles.append([])
        if cycles:
            cycles[-1].append(frame)
    return cycles[:-1]  # the last one is not over


def some_cycles(outsider, count=300):
    mark = outsider.mark()
    hil.wait_for(lambda: len(outsider.since(mark, kind=hil.SYNC)) > count, 30, f"{count} cycles")
    return cycles_of(outsider.since(mark))


def test_a_cycle_is_sync_then_answers_then_commands(host, outsider):
    cycles = some_cycles(outsider)
    in_order = 0
    for cycle in cycles:
        kinds = [f.kind for f in cycle if f.kind in (hil.SYNC, hil.TPDO1, hil.RPDO1)]
        answers, commands = kinds.count(hil.TPDO1), kinds.count(hil.RPDO1)
        in_order += kinds == [hil.SYNC] + [hil.TPDO1] * answers + [hil.RPDO1] * commands
    # A host that wakes late commands late: then the order of that cycle, and of the next, is another.
    assert in_order >= 0.9 * len(cycles)


def test_every_node_answers_every_sync_once(host, outsider):
    cycles = some_cycles(outsider)
    answers = Counter((f.kind, f.node) for cycle in cycles for f in cycle)
    for node in ENCODERS + DRIVES:
        assert answers[hil.TPDO1, node] == pytest.approx(len(cycles), abs=2)
    for node in DRIVES:
        assert answers[hil.RPDO1, node] == pytest.approx(len(cycles), rel=0.05)


def test_sync_keeps_its_period(host, outsider):
    syncs = [cycle[0].time for cycle in some_cycles(outsider, 500)]
    periods = [b - a for a, b in zip(syncs, syncs[1:])]
    assert median(periods) == pytest.approx(PERIOD_S, rel=0.2)
    # On average over the whole time: whole periods that were left out make it longer, never shorter.
    assert (syncs[-1] - syncs[0]) / len(periods) >= 0.95 * PERIOD_S


def test_host_sends_its_heartbeat(host, outsider):
    outsider.wait_for(lambda f: f.kind == hil.HEARTBEAT and f.node == 127 and f.nmt_state == "operational", 5,
                      "heartbeat of the host", outsider.mark())


class TestTorque:
    """A hand that pulls the turret to one side, away from a body that is still on its way, feels torque to the
    other side."""

    @pytest.fixture(params=(1, -1), ids=("left", "right"))
    def side(self, request):
        return request.param

    @pytest.fixture
    def motion(self, side, tmp_path):
        path = tmp_path / "hand.csv"
        rows = [(0, 0), (2, 0)] + [(2 + 0.25 * i, side * 0.5 * (i % 2)) for i in range(1, 80)]
        path.write_text("t,turret,elbow\n" + "".join(f"{t},{q},0\n" for t, q in rows))
        return path

    def test_is_against_the_hand(self, side, host, outsider, simulator):
        def towards(sign):
            """Of the commands to the turret while the hand moves by itself to that side."""
            return [f.target_per_mille for f in outsider.since(0, kind=hil.RPDO1, node=DRIVES[0])
                    if f.target_per_mille * sign > 20]

        hil.wait_for(lambda: towards(-side), 20, "torque against the hand's pull")
        first = next(f for f in outsider.since(0, kind=hil.RPDO1, node=DRIVES[0]) if abs(f.target_per_mille) > 20)
        assert first.target_per_mille * side < 0
        # What the drive reports that it makes has the sign that it was commanded.
        reported = outsider.wait_for(
            lambda f: f.kind == hil.TPDO1 and f.node == DRIVES[0] and abs(f.actual_per_mille) > 20, 5,
            "torque in the drive's status")
        assert reported.actual_per_mille * side < 0


def test_record_is_what_an_outsider_hears(start_host, outsider, tmp_path):
    mark = outsider.mark()
    host = start_host("--duration", "2")
    assert host.popen.wait(30) == 0, host.error_text()
    recorded = [(cob_id, data) for _, cob_id, data in hil.read_candump(host.record_path)]
    assert len(recorded) > 1000

    def heard():
        frames = [(f.id, f.data) for f in outsider.since(mark)]
        return frames if len(frames) >= len(recorded) else None

    heard = hil.wait_for(heard, 5, "all frames of the record")
    # Frame for frame: the same ones, and each sender's in the same order. (Between senders the order is that of
    # their ends of the bus: frames that were on their way at the same time may pass each other.)
    by_id = lambda frames: {i: [d for j, d in frames if i == j] for i in {j for j, _ in frames}}
    ours, theirs = by_id(recorded), by_id(heard)
    for cob_id, data in ours.items():
        them = theirs.get(cob_id, [])
        # Nodes speak before the host listens, and after it has gone.
        assert any(them[i:i + len(data)] == data for i in range(len(them) - len(data) + 1)), hex(cob_id)
