"""Arrays: memory, shapes, and the interpreter's lock."""
import ctypes
import gc
import threading
import time

import numpy as np
import pytest
from godobject import Scene

BY_BODY = {"positions": 3, "quaternions": 4, "twists": 6, "coupling_wrenches": 6, "feedback_wrenches": 6,
           "contact_wrenches": 6, "joint_wrenches": 6, "target_positions": 3, "target_quaternions": 4}


@pytest.mark.parametrize("name", [*BY_BODY, "joint_coordinates", "net_nodes"])
def test_views_share_memory_and_are_read_only(name):
    scene = Scene("sim/scenes/organ-soft.toml", bus="direct")
    view = getattr(scene, name)
    assert view.size > 0 and view.dtype == np.float64
    if name in BY_BODY:
        assert view.shape == (len(scene.bodies), BY_BODY[name])
    scene.step(50)
    assert np.shares_memory(view, getattr(scene, name))
    assert (view == getattr(scene, name)).all()
    scene.reset()
    scene.run(duration=0.05)
    assert np.shares_memory(view, getattr(scene, name)), "also after a reset"
    with pytest.raises(ValueError):
        view[0] = 1
    with pytest.raises(ValueError):
        view.flags.writeable = True


def test_a_view_shows_the_latest_state_and_keeps_the_scene():
    scene = Scene("sim/scenes/wall.toml")
    view, before = scene.positions, scene.positions.copy()
    scene.step(500)
    assert (view != before).any()
    now = view.copy()
    del scene
    gc.collect()
    assert (view == now).all()


def test_quaternions_are_w_x_y_z():
    parts = {"scene": {"name": "turned"},
             "body": [{"name": "a", "mass": 1.0, "inertia": [1e-3, 1e-3, 1e-3], "orientation_wxyz": [0.6, 0.8, 0.0, 0.0]}]}
    assert Scene.from_dict(parts).quaternions.tolist() == [[0.6, 0.8, 0.0, 0.0]]


@pytest.mark.parametrize("name", ["points", "normals", "forces"])
def test_contacts_are_views(name):
    scene = Scene("sim/scenes/lego.toml")
    scene.step(100)
    contacts = scene.contacts
    view = getattr(contacts, name)
    assert len(contacts) == len(contacts.on) == len(contacts.body) > 0 and view.shape == (len(contacts), 3)
    before = view.copy()
    scene.step(100)
    now = getattr(scene.contacts, name)
    n = min(len(view), len(now))
    assert np.shares_memory(view, now) and (view[:n] == now[:n]).all() and (view != before).any()
    with pytest.raises(ValueError):
        view[0] = 1
    del scene, contacts
    gc.collect()
    assert (view[:n] == now[:n]).all()


def test_a_view_of_contacts_that_are_gone_is_zero():
    scene = Scene("sim/scenes/wall.toml")
    scene.run(duration=2.0, every=0)
    pressed = scene.contacts
    assert len(pressed) > 0 and (pressed.forces != 0).any()
    scene.reset()
    assert len(scene.contacts) == 0 and not pressed.forces.any()


def test_rows_are_their_own_memory():
    scene = Scene("sim/scenes/wall.toml")
    rows = scene.run(duration=0.1)
    kept = rows.positions.copy()
    scene.run(duration=0.3, every=0)
    assert (rows.positions == kept).all() and not rows.positions.flags.writeable


def ran_meanwhile(call):
    """True if another thread ran in the middle half of the call, which takes long enough for it."""
    ticks, stop = [], threading.Event()

    def tick():
        while not stop.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    try:
        start = time.monotonic()
        call()
        end = time.monotonic()
    finally:
        stop.set()
        thread.join()
    assert end - start > 0.1
    return any(start + (end - start) / 4 < t < end - (end - start) / 4 for t in ticks)


def test_other_threads_run_during_steps():
    scene = Scene("sim/scenes/lego.toml")
    assert ran_meanwhile(lambda: scene._step(4000, 0)), "one call, without Python code within"
    assert not ran_meanwhile(lambda: ctypes.PyDLL(None).usleep(200_000)), "it keeps the lock"


def test_a_scene_that_steps_refuses_other_threads():
    scene = Scene("sim/scenes/lego.toml")
    thread = threading.Thread(target=scene.step, args=(3000,))
    thread.start()
    refused = []
    while thread.is_alive() and not refused:
        try:
            scene.state_hash
        except RuntimeError as error:
            refused.append(str(error))
    assert refused == ["the scene is stepping in another thread: wait for it"]
    assert scene.t <= 3  # views can be read meanwhile
    thread.join()
    assert scene.steps == 3000
