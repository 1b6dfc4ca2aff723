"""Files of `godobject run` as arrays. Units and columns: docs/scenes.md, Trace."""
import csv
import json
import os
import warnings
from collections.abc import Iterator, Mapping
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from .errors import Problem, ReadError, SceneWarning
from .hil.errors import HilError
from .hil.frames import read_candump

Report = dict[str, Any]

_POINTS = ("x", "y", "z")
_QUATERNION = ("qw", "qx", "qy", "qz")
_TWIST = ("vx", "vy", "vz", "wx", "wy", "wz")
_WRENCH = ("fx", "fy", "fz", "tx", "ty", "tz")


class Trace(Mapping[str, NDArray[np.float64]]):
    """Columns by name, each an array over time; a file of `run --trace`, `run --nets`, or a .godo file.

    data: all of them, (rows, columns).

    >>> trace = Trace(["t", "tool.x", "tool.y", "tool.z"], np.array([[0, 1, 2, 3], [0.001, 1.5, 2, 3]]))
    >>> trace["tool.x"]
    array([1. , 1.5])
    >>> trace.positions("tool").shape
    (2, 3)
    """

    def __init__(self, columns: list[str], data: NDArray[np.float64]):
        self.columns, self.data = columns, data
        self._index = {name: i for i, name in enumerate(columns)}

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self.data[:, self._index[name]]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    def __repr__(self) -> str:
        return f"<Trace: {len(self.data)} rows of {len(self.columns)} columns>"

    @property
    def t(self) -> NDArray[np.float64]:
        return self["t"]

    def positions(self, of: str) -> NDArray[np.float64]:
        """Returns (rows, 3): x, y, z of a body, "BODY.target", "TARGET.device", "NET.NUMBER" or "BODY.input"."""
        return self._columns(of, _POINTS)

    def quaternions(self, of: str) -> NDArray[np.float64]:
        """Returns (rows, 4): w, x, y, z of a body, "BODY.target", "TARGET.device" or "BODY.input"."""
        return self._columns(of, _QUATERNION)

    def twists(self, body: str) -> NDArray[np.float64]:
        """Returns (rows, 6): velocity and angular velocity."""
        return self._columns(body, _TWIST)

    def wrenches(self, of: str) -> NDArray[np.float64]:
        """Returns (rows, 6): force and torque of "BODY.coupling", ".feedback", ".contact", a joint or "hand"."""
        return self._columns(of, _WRENCH)

    def _columns(self, of: str, suffixes: tuple[str, ...]) -> NDArray[np.float64]:
        missing = [f"{of}.{suffix}" for suffix in suffixes if f"{of}.{suffix}" not in self._index]
        if missing:
            raise KeyError(f"the trace has no column {missing[0]!r}")
        return self.data[:, [self._index[f"{of}.{suffix}"] for suffix in suffixes]]


def read_trace(path: str | os.PathLike[str]) -> Trace:
    """Reads the file of `run --trace` or `run --nets`, or a .godo file of `run --record` or `--on-fault`.

    The last line of a run that was killed is left out. Raises ReadError with line and column.

    A .godo file has states and forces as a trace, bit for bit, and each sample that the core received: of a body the
    pose BODY.input.x, ..., .qz, the twist .vx, ..., the hand's wrench .fx, ..., coordinates .q1, .q2 of a prescribed
    joint, and .valid, .engaged, .clutch. Needs the compiled module. Missing rows are a SceneWarning.
    """
    if _begin(path).startswith(b"godolog"):
        return _read_input_log(path)
    lines = _lines(path)
    columns = lines[0].split(",")
    if columns[0] != "t":
        _refuse(path, "the first column is not 't': give a file of run --trace or --nets", 1)
    rows = [line for line in lines[1:] if line]
    if not rows:
        return Trace(columns, np.empty((0, len(columns))))
    try:
        data = np.loadtxt(rows, delimiter=",", ndmin=2, comments=None)
    except ValueError:
        data = None
    if data is None or data.shape[1] != len(columns):
        _refuse_row(path, lines, len(columns))
    return Trace(columns, data)


def _begin(path: str | os.PathLike[str]) -> bytes:
    try:
        with open(path, "rb") as file:
            return file.read(16)
    except OSError as error:
        _refuse(path, f"cannot be read: {error.strerror}", None)


def _read_input_log(path: str | os.PathLike[str]) -> Trace:
    from ._core import read_input_log
    columns, data, note = read_input_log(os.fspath(path))
    if note:
        warnings.warn(f"{os.fspath(path)}: {note}", SceneWarning, stacklevel=3)
    return Trace(columns, data)


CONTACT = np.dtype([("t", "f8"), ("body", "U64"), ("on", "U64"), ("point", "f8", 3), ("normal", "f8", 3), ("force", "f8", 3)])


def read_contacts(path: str | os.PathLike[str]) -> NDArray[np.void]:
    """Reads the file of `run --contacts`: one element a contact, with fields t, body, on, point, normal, force."""
    lines = _lines(path)
    if lines[0] != "t,body,on,x,y,z,nx,ny,nz,fx,fy,fz":
        _refuse(path, "the columns are not those of run --contacts", 1)
    rows = []
    for number, row in enumerate(csv.reader(lines[1:]), 2):
        wrong = next((i for i, text in enumerate(row) if i not in (1, 2) and not _is_number(text)), min(len(row), 12))
        if (wrong, len(row)) != (12, 12):
            _refuse(path, "the line is not that of a contact", number, _column(row, wrong))
        t, *x = (float(text) for text in [row[0], *row[3:]])
        rows.append((t, row[1], row[2], x[:3], x[3:6], x[6:9]))
    return np.array(rows, dtype=_with_names(CONTACT, body=[row[1] for row in rows], on=[row[2] for row in rows]))


FRAME = np.dtype([("t_ns", "i8"), ("bus", "U16"), ("id", "u4"), ("extended", "?"), ("length", "u1"), ("data", "u1", 64)])


def read_recording(path: str | os.PathLike[str]) -> NDArray[np.void]:
    """Reads the log of `run --record` or `candump -l`: one element a frame, with the fields of FRAME.

    t_ns: since 1970 on a rig, ns; of simulated buses their own clock. data: the rest is 0. Remote frames are left out.
    """
    try:
        frames = list(read_candump(os.fspath(path)))
    except OSError as error:
        _refuse(path, f"cannot be read: {error.strerror}", None)
    except HilError as error:
        _refuse(path, error.text, int(error.where.rpartition(":")[2]))
    log = np.zeros(len(frames), dtype=_with_names(FRAME, bus=[frame.bus for frame in frames]))
    for row, frame in zip(log, frames):
        row["t_ns"] = round(frame.time * 1e6) * 1000
        row["bus"], row["id"], row["extended"], row["length"] = frame.bus, frame.id, frame.extended, len(frame.data)
        row["data"][:len(frame.data)] = np.frombuffer(frame.data, np.uint8)
    return log


def _with_names(kind: np.dtype[np.void], **names: list[str]) -> np.dtype[np.void]:
    """Returns the type with fields that are wide enough for these names, which numpy would cut."""
    assert kind.names is not None and kind.fields is not None
    fields = {field: kind.fields[field][0] for field in kind.names}
    for field, texts in names.items():
        fields[field] = np.dtype(f"U{max([fields[field].itemsize // 4, *map(len, texts)])}")
    return np.dtype(list(fields.items()))


def read_report(path: str | os.PathLike[str]) -> Report:
    """Reads the file of `run --report`; lists of numbers, as the histograms, are arrays."""
    try:
        report: Report = _with_arrays(json.loads(_text(path)))
        return report
    except json.JSONDecodeError as error:
        _refuse(path, f"not JSON: {error.msg}", error.lineno, error.colno)


def _with_arrays(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _with_arrays(one) for key, one in value.items()}
    if not isinstance(value, list) or not value:
        return value
    is_number = all(isinstance(one, (int, float)) and not isinstance(one, bool) for one in value)
    is_table = all(isinstance(one, list) and len(one) == len(value[0]) for one in value if isinstance(value[0], list))
    if is_number or (is_table and isinstance(value[0], list)
                     and all(isinstance(x, (int, float)) for one in value for x in one)):
        return np.array(value, dtype=np.float64)
    return [_with_arrays(one) for one in value]


def _text(path: str | os.PathLike[str]) -> str:
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            return file.read()
    except OSError as error:
        _refuse(path, f"cannot be read: {error.strerror}", None)


def _lines(path: str | os.PathLike[str]) -> list[str]:
    """The lines without their ends, and without a last one that has none."""
    text = _text(path)
    lines = text.replace("\r\n", "\n").split("\n")[:-1]
    if not lines:
        _refuse(path, "the file has no line of columns' names", 1)
    return lines


def _refuse_row(path: str | os.PathLike[str], lines: list[str], columns: int) -> NoReturn:
    """Refuses the first line that is not numbers, or not as many as there are columns."""
    for number, line in enumerate(lines[1:], 2):
        fields = line.split(",")
        if line and len(fields) != columns:
            _refuse(path, f"the line has {len(fields)} numbers in place of {columns}", number)
        for i, field in enumerate(fields if line else []):
            if not _is_number(field):
                _refuse(path, f"{field[:40]!r} is not a number", number, _column(fields, i))
    _refuse(path, "the lines are not numbers between commas", 2)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _column(fields: list[str], i: int) -> int:
    """Returns the column, from 1, at which the i-th field of a line begins."""
    return 1 + sum(len(field) + 1 for field in fields[:i])


def _refuse(path: str | os.PathLike[str], message: str, line: int | None, column: int | None = None) -> NoReturn:
    raise ReadError([Problem(message, os.fspath(path), line, column or (1 if line else None))])
