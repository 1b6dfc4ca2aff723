"""Readers of the files of `godobject run`."""
import numpy as np
import pytest
from godobject import ReadError, read_contacts, read_recording, read_report, read_trace


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
    assert caught.value.line == 6
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


def test_a_report_has_arrays(files):
    report, _ = files
    histogram = report["timing"]["compute_us"]["histogram"]
    assert isinstance(histogram, np.ndarray) and histogram.shape[1] == 2
    assert histogram[:, 1].sum() == report["cycles"] == 300
    assert report["faults"] == []
