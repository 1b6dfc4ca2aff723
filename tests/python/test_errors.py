"""Mistakes of users: exceptions with place or key."""
import pickle
import signal
import threading
import tomllib
import types

import numpy as np
import pytest
from godobject import FaultError, MotionError, Scene, SceneError, SceneWarning

WALL = "sim/scenes/wall.toml"


@pytest.fixture
def wall():
    with open(WALL, "rb") as file:
        return tomllib.load(file)


def changed(tmp_path, old, new):
    text = open(WALL).read()
    assert old in text
    path = tmp_path / "scene.toml"
    path.write_text(text.replace(old, new, 1))
    return path


def line_of(path, text):
    return next(i for i, line in enumerate(path.read_text().splitlines(), 1) if text in line)


def test_a_bad_value_has_file_line_and_column(tmp_path):
    path = changed(tmp_path, "mass = ", "mass = -")
    with pytest.raises(SceneError) as caught:
        Scene(path)
    error = caught.value
    assert error.file == str(path) and error.line == line_of(path, "mass = -") and error.column == 8
    assert "out of range" in error.message and "scene.toml" not in error.message
    assert str(error).startswith(f"{path}:{error.line}:8: ")
    assert error.key is None


def test_all_errors_are_reported(tmp_path):
    path = changed(tmp_path, "mass = ", "mas = 1\nmass = -")
    with pytest.raises(SceneError) as caught:
        Scene(path)
    assert [problem.line for problem in caught.value.problems] == [line_of(path, "mas = 1"), line_of(path, "mass = -")]
    assert pickle.loads(pickle.dumps(caught.value)).problems == caught.value.problems


def test_not_toml_and_no_file(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text("[scene]\nname = \n")
    with pytest.raises(SceneError) as caught:
        Scene(path)
    assert caught.value.line == 2 and "not TOML" in caught.value.message
    with pytest.raises(SceneError) as caught:
        Scene(tmp_path / "absent.toml")
    assert caught.value.line is None and "cannot be read" in caught.value.message
    assert caught.value.file == str(tmp_path / "absent.toml")


def test_dicts_are_the_file(wall):
    by_file, by_dict = Scene(WALL), Scene.from_dict(wall, folder="sim/scenes")
    by_file.step(300)
    by_dict.step(300)
    assert by_file.state_hash == by_dict.state_hash


@pytest.mark.filterwarnings("ignore::godobject.SceneWarning")
@pytest.mark.parametrize("scene", ["grasper", "endobag", "sewn", "lego", "admittance"])
def test_dicts_of_every_kind_of_table(scene):
    path = f"sim/scenes/{scene}.toml"
    with open(path, "rb") as file:
        parts = tomllib.load(file)
    by_file, by_dict = Scene(path), Scene.from_dict(parts, folder="sim/scenes")
    by_file.step(20)
    by_dict.step(20)
    assert by_file.state_hash == by_dict.state_hash


def test_a_mistake_in_a_dict_names_its_key(wall):
    def refused():
        with pytest.raises(SceneError) as caught:
            Scene.from_dict(wall)
        assert caught.value.line is None
        return caught.value

    wall["body"][0]["coupling"]["stiffness"] = -5
    error = refused()
    assert error.key == "body[0].coupling.stiffness" and str(error).startswith(error.key + ": ")
    wall["body"][0]["coupling"]["stiffness"] = 100.0
    wall["body"][0]["massa"] = 1
    assert refused().key == "body[0].massa"
    del wall["body"][0]["massa"], wall["body"][0]["mass"]
    error = refused()
    assert error.key == "body[0]" and "'mass'" in error.message
    wall["body"][0]["mass"] = None
    error = refused()
    assert error.key == "body[0].mass" and "None" in error.message
    wall["body"][0]["mass"] = {1: 2}
    assert refused().key == "body[0].mass"
    wall["body"][0]["mass"] = object()
    assert "object" in refused().message


def test_values_of_numpy_and_odd_texts(wall):
    wall["body"][0]["position"] = np.zeros(3)
    wall["body"][0]["mass"] = np.float64(0.25)
    wall["scene"]["about"] = 'line\n"quoted" \\ \x7f \x01 ä'
    Scene.from_dict(wall)


def test_every_kind_of_mapping_and_number(wall):
    body = wall["body"][0]
    body["mass"], body["position"] = np.float32(0.25), [np.int64(0), np.float64(-0.04), 0]
    wall["scene"] = types.MappingProxyType(wall["scene"])
    wall["body"] = (types.MappingProxyType(body),)
    scene = Scene.from_dict(types.MappingProxyType(wall))
    assert scene.positions[0].tolist() == [0, -0.04, 0]
    body["pins"] = np.bool_(True)
    with pytest.raises(SceneError) as caught:
        Scene.from_dict(wall)
    assert caught.value.key == "body[0].pins"


@pytest.mark.parametrize("key", ["two words", 'a"b', "ä.b", "\U0001f600", "", "line\nbreak"])
def test_odd_keys_are_named(wall, key):
    wall["body"][0][key] = 1.5
    with pytest.raises(SceneError) as caught:
        Scene.from_dict(wall)
    assert caught.value.key == "body[0]." + key and "unknown key" in caught.value.message


def test_keys_and_values_that_no_scene_has(wall):
    body = wall["body"][0]
    for value, message in (({3: 1}, "the key 3 is not a str"), ([1.0, {"a": 1}], "a dict, which scenes do not have"),
                           ([None], "None"), (1j, "a complex"), (np.array([1j]), "a complex")):
        body["mass"] = value
        with pytest.raises(SceneError, match=message) as caught:
            Scene.from_dict(wall)
        assert caught.value.key == "body[0].mass"
    body["mass"] = body
    with pytest.raises(RecursionError):
        Scene.from_dict(wall)
    body["mass"] = "\ud800"
    with pytest.raises(UnicodeEncodeError):
        Scene.from_dict(wall)


def test_advice_is_a_warning(wall):
    wall["body"][0]["inertia"] = [1e-5, 1e-5, 1e-3]
    with pytest.warns(SceneWarning, match=r"^body\[0\].inertia: .*not that of a solid") as caught:
        Scene.from_dict(wall)
    assert caught[0].filename == __file__


def test_a_motion_that_starts_far_away_is_refused_as_by_run(wall):
    scene = Scene(WALL)
    far = np.zeros((2, 8))
    far[:, 0], far[:, 1], far[:, 4] = (0, 1), 5, 1
    with pytest.raises(MotionError, match="starts 5.000 m .* from its target; at most 1 m"):
        scene.run(far)
    far[:, 1] = 0.5
    with pytest.warns(SceneWarning, match="starts 0.500 m"):
        scene.reset(far)
    wall["motion"]["position"] = [5.0, 0.0, 0.0]
    with pytest.raises(SceneError, match="from its target"):
        Scene.from_dict(wall)


def test_columns_that_are_not_used_are_a_warning(tmp_path):
    path = tmp_path / "m.csv"
    path.write_text("t,peg.x,peg.y,peg.z,peg.qw,peg.qx,peg.qy,peg.qz,more\n0,0,0,0,1,0,0,0,0\n1,0,0,0,1,0,0,0,0\n")
    with pytest.warns(SceneWarning, match="'more' is not used"):
        Scene(WALL).run(path)


def test_a_bad_motion_has_its_place(tmp_path):
    scene = Scene(WALL)
    path = tmp_path / "m.csv"
    path.write_text("t,peg.x,peg.y,peg.z,peg.qw,peg.qx,peg.qy,peg.qz\n0,0,0,0,1,0,0,0\n1,0,0,0,2,0,0,0\n")
    with pytest.raises(MotionError) as caught:
        scene.run(path)
    assert (caught.value.file, caught.value.line, caught.value.column) == (str(path), 3, 9)
    with pytest.raises(MotionError, match=r"\(N, 8\)"):
        scene.run(np.zeros((4, 5)))
    bad = np.zeros((2, 8))
    bad[:, 4] = 1
    with pytest.raises(MotionError) as caught:
        scene.run(bad)
    assert caught.value.line == 3 and "strictly increasing" in caught.value.message
    with pytest.raises(MotionError, match="cannot be read"):
        scene.run(tmp_path / "absent.csv")
    scene.step(10)  # it is as it was
    assert scene.steps == 10


@pytest.fixture
def unplugged(tmp_path):
    """The rig of sim/scenes/rigid.toml, of which an encoder is unplugged at 0.3 s."""
    with open("sim/scenes/rigid.toml", "rb") as file:
        parts = tomllib.load(file)
    encoder = parts["device"]["encoder"][0]
    parts["fault"] = [{"at": 0.3, "verb": "unplug", "bus": encoder["bus"], "node_id": encoder["node_id"]}]
    return parts


def test_a_fault_is_raised_by_its_name(unplugged):
    scene = Scene.from_dict(unplugged, folder="sim/scenes")
    with pytest.raises(FaultError) as caught:
        scene.step(1000)
    error = caught.value
    assert "sample_stale" in error.faults and 0.3 < error.t < 0.5
    assert scene.t == error.t and scene.faults["sample_stale"] == error.t
    assert "sample_stale at t = " in str(error) and all(error.remedies)
    scene.step(10)  # a fault that lasts is raised once
    assert scene.t > error.t
    assert pickle.loads(pickle.dumps(error)).faults == error.faults


def test_faults_can_be_reported_instead(unplugged):
    scene = Scene.from_dict(unplugged, folder="sim/scenes", on_fault="report")
    rows = scene.run(duration=1.0)
    assert len(rows) == 1001 and 0.3 < scene.faults["sample_stale"] < 0.5
    scene.reset()
    assert scene.faults == {}


def test_a_device_that_does_not_come_up_is_a_fault(unplugged):
    unplugged["fault"][0]["at"] = 0
    with pytest.raises(FaultError) as caught:
        Scene.from_dict(unplugged, folder="sim/scenes")
    assert caught.value.faults == ("not_ready",) and "boot_timeout" in str(caught.value)


def test_ctrl_c_ends_a_step():
    scene = Scene(WALL)
    timer = threading.Timer(0.2, signal.raise_signal, [signal.SIGINT])
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        scene.step(10**12)
    steps = scene.steps
    scene.step(1)
    assert scene.steps == steps + 1


def test_wrong_arguments_are_refused():
    scene = Scene(WALL)
    for call in (lambda: scene.step(-1), lambda: scene.run(every=-1), lambda: scene.run(duration=0),
                 lambda: scene.run(duration=float("nan")), lambda: Scene(WALL, bus="can0"),
                 lambda: Scene(WALL, on_fault="ignore")):
        with pytest.raises(ValueError):
            call()
    with pytest.raises(SceneError, match="bus='direct'"):
        Scene(WALL, bus="sim")


@pytest.fixture
def rig(tmp_path):
    """Text of tests/hil/rig.toml and its profile, as a function that writes both with changes and returns the scene."""

    def write(*changes):
        for name in ("rig.toml", "patient-402.toml"):
            text = open(f"tests/hil/{name}").read()
            for old, new in changes:
                text = text.replace(old, new)
            (tmp_path / name).write_text(text)
        return tmp_path / "rig.toml"

    return write


@pytest.mark.filterwarnings("ignore::godobject.SceneWarning")
@pytest.mark.parametrize("change, column, message", [
    (("mode = 10 ", "mode = 300 "), 8, "'mode' is 300"), (("mode = 10 ", "mode = 8 "), None, "mode 8 ignores"),
    (("[drive]", "[drive"), 7, "not TOML")])
def test_an_error_of_a_profile_has_the_place_in_the_profile(rig, tmp_path, change, column, message):
    scene, profile = rig(change), tmp_path / "patient-402.toml"
    for load in (lambda: Scene(scene), lambda: Scene.from_dict(tomllib.loads(scene.read_text()), folder=tmp_path)):
        with pytest.raises(SceneError) as caught:
            load()
        error = caught.value
        assert (error.file, error.column, error.key) == (str(profile), column, None) and error.message.startswith(message)
        assert error.line == line_of(profile, change[1])
        assert str(error).splitlines()[0].startswith(f"{profile}:{error.line}:")


def test_a_profile_that_is_not_there_is_an_error_of_the_scene(rig, tmp_path):
    scene = rig(('"patient-402"', '"none-such"'))
    with pytest.raises(SceneError, match='profile "none-such" was found neither') as caught:
        Scene(scene)
    assert caught.value.file == str(scene) and caught.value.line == line_of(scene, '"none-such"')
    with pytest.raises(SceneError, match='profile "none-such" was found neither') as caught:
        Scene.from_dict(tomllib.loads(scene.read_text()), folder=tmp_path)
    assert caught.value.key == "device.drive[0].profile"
