"""States are those of `godobject run --fast`, bit for bit."""
import numpy as np
import pytest
from godobject import Scene, read_contacts, read_trace

SCENES = ["wall", "rigid", "grasper", "relative", "admittance", "tracked", "palpate", "net-small", "chain", "lego"]


@pytest.mark.filterwarnings("ignore::godobject.SceneWarning")
@pytest.mark.parametrize("scene", SCENES)
def test_the_state_is_that_of_run(run, scene):
    path = f"sim/scenes/{scene}.toml"
    report = run(path, "--duration", "0.4")
    by_steps = Scene(path)
    for n in (1, 7, 0, 392):
        by_steps.step(n)
    assert by_steps.state_hash == report["state_hash"]
    by_steps.run(duration=0.4, every=0)
    assert by_steps.state_hash == report["state_hash"]
    assert by_steps.limits == report["limits"]


def test_rows_are_those_of_the_trace(run, tmp_path):
    report = run("sim/scenes/palpate.toml", "--duration", "1.2", "--trace", "{}/t.csv", "--contacts", "{}/c.csv")
    trace, contacts = read_trace(tmp_path / "t.csv"), read_contacts(tmp_path / "c.csv")
    scene = Scene("sim/scenes/palpate.toml")
    rows = scene.run(duration=1.2)
    assert len(rows) == len(trace.t) == report["cycles"] + 1
    assert (rows.t == trace.t).all() and (rows.energy == trace["energy"]).all()
    for i, body in enumerate(scene.bodies):
        assert (rows.positions[:, i] == trace.positions(body)).all(), body
        assert (rows.quaternions[:, i] == trace.quaternions(body)).all(), body
        assert (rows.twists[:, i] == trace.twists(body)).all(), body
    i = scene.bodies.index(scene.targets[0])
    assert (rows.feedback_wrenches[:, i] == trace.wrenches(scene.targets[0] + ".feedback")).all()
    assert (rows.coupling_wrenches[:, i] == trace.wrenches(scene.targets[0] + ".coupling")).all()
    assert (rows.target_positions[:, i] == trace.positions(scene.targets[0] + ".target")).all()
    last = contacts[contacts["t"] == rows.t[-1]]
    assert len(last) == len(scene.contacts) > 0
    assert (last["point"] == scene.contacts.points).all() and (last["force"] == scene.contacts.forces).all()
    assert (last["normal"] == scene.contacts.normals).all()
    assert list(last["body"]) == scene.contacts.body and list(last["on"]) == scene.contacts.on


def test_nodes_of_nets_are_those_of_the_file(run, tmp_path):
    run("sim/scenes/net-small.toml", "--duration", "0.4", "--nets", "{}/n.csv", "--nets-every", "400")
    nets = read_trace(tmp_path / "n.csv")
    scene = Scene("sim/scenes/net-small.toml")
    scene.step(400)
    assert (scene.net_nodes.ravel() == nets.data[-1, 1:]).all()


def test_a_motion_is_a_file_or_an_array(run, tmp_path):
    t = np.linspace(0, 0.3, 31)
    motion = np.zeros((31, 8))
    motion[:, 0], motion[:, 1], motion[:, 4] = t, 0.09 * t / 0.3, 1
    header = "t," + ",".join(f"peg.{suffix}" for suffix in ("x", "y", "z", "qw", "qx", "qy", "qz"))
    np.savetxt(tmp_path / "m.csv", motion, fmt="%.17g", delimiter=",", header=header, comments="")
    report = run("sim/scenes/wall.toml", "--motion", "{}/m.csv")
    scene = Scene("sim/scenes/wall.toml")
    assert scene.targets == ["peg"]
    for given in (tmp_path / "m.csv", str(tmp_path / "m.csv"), motion, motion.tolist()):
        scene.run(given, every=0)
        assert scene.steps == report["cycles"] == 300
        assert scene.state_hash == report["state_hash"]


def test_every_nth_state_is_kept():
    scene = Scene("sim/scenes/wall.toml")
    all_rows, some = scene.run(duration=0.1), scene.run(duration=0.1, every=30)
    assert some.t.tolist() == all_rows.t[::30].tolist()
    assert (some.positions == all_rows.positions[::30]).all()
    assert scene.run(duration=0.1, every=0) is None
    assert (scene.positions == all_rows.positions[-1]).all()


def test_direct_and_simulated_devices(run):
    hashes = set()
    for bus in ("sim", "direct"):
        report = run("sim/scenes/rigid.toml", "--bus", bus, "--duration", "0.2")
        scene = Scene("sim/scenes/rigid.toml", bus=bus)
        scene.step(200)
        assert scene.state_hash == report["state_hash"]
        hashes.add(scene.state_hash)
    assert len(hashes) == 2
