"""Readers of the files of `godobject run`."""
import re
import warnings

import numpy as np
import pytest
from godobject import ReadError, Scene, SceneWarning, read_contacts, read_recording, read_report, read_trace


@pytest.fixture
def files(run, tmp_path):
    report = run("sim/scenes/palpate.toml", "--duration", "0.3", "--trace", "{}/t.csv", "--contacts", "{}/c.csv",
                 "--record", "{}/bus.log")
    return report, tmp_path


def test_a_trace_is_arrays(files):
    _, folder = files
    trace = read_trace(folder / "t.csv")
    header = (folder / "t.csv").read_text().splitlines()[0].split(",")
    assert list(trace) == trace.columns == header and trace.data.shape == (301, len(header))
    assert np.shares_memory(trace["t"], trace.data) and trace.t[-1] == 0.3
    body = header[1].removesuffix(".x")
    assert trace.positions(body).shape == (301, 3) and trace.twists(body).shape == (301, 6)
    assert np.allclose(np.linalg.norm(trace.quaternions(body), axis=1), 1)
    with pytest.raises(KeyError, match="nosuch.x"):
        trace.positions("nosuch")


def test_a_killed_run_loses_its_last_line(files):
    _, folder = files
    text = (folder / "t.csv").read_text()
    (folder / "cut.csv").write_text(text[:-30])
    assert len(read_trace(folder / "cut.csv").t) == 300
    (folder / "empty.csv").write_text(text.splitlines()[0] + "\n")
    assert len(read_trace(folder / "empty.csv").t) == 0


def test_bad_lines_are_named(files):
    _, folder = files
    lines = (folder / "t.csv").read_text().splitlines()
    lines[5] = lines[5].rpartition(",")[0]
    (folder / "short.csv").write_text("\n".join(lines) + "\n")
    with pytest.raises(ReadError) as caught:
        read_trace(folder / "short.csv")
    assert caught.value.line == 6 and caught.value.file == str(folder / "short.csv")
    lines[5] = lines[4].replace("0", "zero", 1)
    (folder / "word.csv").write_text("\n".join(lines) + "\n")
    with pytest.raises(ReadError, match="zero") as caught:
        read_trace(folder / "word.csv")
    assert caught.value.line == 6 and caught.value.column == lines[5].rfind(",", 0, lines[5].find("zero")) + 2
    header = (folder / "c.csv").read_text().splitlines()[0]
    for line, column in (("1,peg,wall,1,2,3,4,5,6,7,x,9", 26), ("1,peg,wall,1,2,3,4,5,6,7,8", 28),
                         ("1,peg,wall,1,2,3,4,5,6,7,8,9,1", 30), ("?,peg,wall,1,2,3,4,5,6,7,8,9", 1)):
        (folder / "contacts.csv").write_text(header + "\n" + line + "\n")
        with pytest.raises(ReadError) as caught:
            read_contacts(folder / "contacts.csv")
        assert caught.value.line == 2 and caught.value.column == column
    (folder / "odd.csv").write_text("t,x\n0,1_000\n")  # a number for Python, not for numpy
    with pytest.raises(ReadError):
        read_trace(folder / "odd.csv")
    for read in (read_trace, read_contacts, read_recording, read_report):
        with pytest.raises(ReadError, match="cannot be read") as caught:
            read(folder / "absent")
        assert caught.value.line is None
    with pytest.raises(ReadError, match="first column"):
        read_trace(folder / "bus.log")
    with pytest.raises(ReadError, match="columns"):
        read_contacts(folder / "t.csv")
    with pytest.raises(ReadError) as caught:
        read_recording(folder / "t.csv")
    assert caught.value.line == 1


def test_a_recording_is_an_array_of_frames(files):
    _, folder = files
    log = read_recording(folder / "bus.log")
    lines = (folder / "bus.log").read_text().splitlines()
    assert len(log) == len(lines) > 100
    for row, line in list(zip(log, lines))[::97]:
        time, bus, frame = line.split()[:3]
        can_id, _, data = frame.partition("#")
        assert row["t_ns"] == round(float(time.strip("()")) * 1e6) * 1000
        assert row["bus"] == bus and row["id"] == int(can_id, 16)
        assert row["data"][:row["length"]].tobytes() == bytes.fromhex(data)
        assert not row["data"][row["length"]:].any()


def test_long_names_are_whole(tmp_path):
    bus, body = "a_bus_with_a_name_of_more_than_16", "b" * 80
    (tmp_path / "bus.log").write_text(f"(1.5) {bus} 18B#3712\n(1.6) can1 080#\n")
    log = read_recording(tmp_path / "bus.log")
    assert log["bus"].tolist() == [bus, "can1"] and log["data"][0][:2].tobytes() == b"\x37\x12"
    (tmp_path / "c.csv").write_text(f"t,body,on,x,y,z,nx,ny,nz,fx,fy,fz\n1,{body},wall,1,2,3,4,5,6,7,8,9\n")
    contacts = read_contacts(tmp_path / "c.csv")
    assert contacts["body"].tolist() == [body] and contacts["force"].tolist() == [[7, 8, 9]]
    (tmp_path / "c.csv").write_text("t,body,on,x,y,z,nx,ny,nz,fx,fy,fz\n")
    assert len(read_contacts(tmp_path / "c.csv")) == 0


def test_a_report_has_arrays(files):
    report, _ = files
    histogram = report["timing"]["compute_us"]["histogram"]
    assert isinstance(histogram, np.ndarray) and histogram.shape[1] == 2
    assert histogram[:, 1].sum() == report["cycles"] == 300
    assert report["faults"] == []


SCENES = ["wall", "palpate", "rigid", "grasper", "chain", "relative", "admittance", "net-small", "scissors-imposed", "grasp"]


@pytest.mark.parametrize("scene", SCENES)
def test_an_input_log_is_arrays(run, tmp_path, scene):
    report = run(f"sim/scenes/{scene}.toml", "--duration", "0.3", "--trace", "{}/t.csv", "--record", "{}/run.godo")
    trace, log = read_trace(tmp_path / "t.csv"), read_trace(tmp_path / "run.godo")
    assert log.data.shape == (report["cycles"] + 1, len(log.columns)) and not log.data.flags.writeable
    only_in_traces = re.compile(r".*\.(target|device|hand)\.|.*\.(engaged|clutch)$|energy|penetration$|contact|net_")
    assert all(name in log or only_in_traces.match(name) for name in trace)
    for name in filter(log.__contains__, trace):
        assert np.array_equal(trace[name][1:], log[name][1:], equal_nan=True), name
    assert (log["fault"] == trace["fault"]).all() and (log["limited"] == trace["limited"]).all()
    for body in Scene(f"sim/scenes/{scene}.toml").bodies:
        assert (log.positions(body) == trace.positions(body)).all() and (log.twists(body) == trace.twists(body)).all()
        assert set(log[f"{body}.input.valid"]) <= {0, 1}


def test_inputs_of_a_log_are_those_of_the_core(run, tmp_path):
    run("sim/scenes/wall.toml", "--duration", "0.5", "--trace", "{}/t.csv", "--record", "{}/run.godo")
    trace, log = read_trace(tmp_path / "t.csv"), read_trace(tmp_path / "run.godo")
    assert (log.positions("peg.input")[1:] == trace.positions("peg.target")[1:]).all()
    assert np.ptp(log.positions("peg.input")[:, 0]) > 1e-3 and (log["peg.input.engaged"][1:] == 1).all()


def test_a_cut_or_damaged_input_log_warns(run, tmp_path):
    run("sim/scenes/wall.toml", "--duration", "0.5", "--record", "{}/run.godo")
    path, whole = tmp_path / "run.godo", (tmp_path / "run.godo").read_bytes()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rows = read_trace(path)
    path.write_bytes(whole[:-2000])
    with pytest.warns(SceneWarning, match="was cut") as caught:
        cut = read_trace(path)
    assert caught[0].filename == __file__
    assert 1 < len(cut.t) < len(rows.t) and (cut.data == rows.data[:len(cut.t)]).all()
    damaged = bytearray(whole)
    damaged[len(whole) // 2] ^= 1
    path.write_bytes(damaged)
    with pytest.warns(SceneWarning, match="damaged bytes"):
        assert 1 < len(read_trace(path).t) < len(rows.t)
    for bytes_, message in ((whole[:200], "was cut at its beginning"), (b"godolog9" + whole[8:], "another format")):
        path.write_bytes(bytes_)
        with pytest.raises(ReadError, match=message) as error:
            read_trace(path)
        assert error.value.file == str(path)
