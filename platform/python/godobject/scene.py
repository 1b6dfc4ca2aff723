"""Scene: the session of `godobject run`, without its clock and files."""
import dataclasses
import io
import os
import pathlib
import warnings
from collections.abc import Iterable, Mapping
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import MotionError, Problem, SceneError, SceneWarning

try:
    from ._core import Session, keys_of_dict
except ImportError as error:
    raise ImportError("godobject has no compiled module: install pybind11-dev, python3-dev and python3-numpy, build "
                      "(./dev build release), and run the Python that it was built for; put the build directory's "
                      f"platform/python into PYTHONPATH if it is not build/release ({error})") from error

_POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")
_WRENCH = ("fx", "fy", "fz", "tx", "ty", "tz")


@dataclasses.dataclass(frozen=True)
class Contacts:
    """The n contacts of a state that bear a force.

    points: m, world. normals: towards `body`. forces: on `body`, N, mean over the step; each (n, 3), a view of the
    scene's memory: take `contacts` again after a step, which may change their number.
    body: of the sphere or edge, or net of the node. on: the other body, net or obstacle.
    """
    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    forces: NDArray[np.float64]
    body: list[str]
    on: list[str]

    def __len__(self) -> int:
        return len(self.body)


@dataclasses.dataclass(frozen=True)
class Rows:
    """States of a run over time: the arrays of Scene with a leading axis for time."""
    t: NDArray[np.float64]
    energy: NDArray[np.float64]
    positions: NDArray[np.float64]
    quaternions: NDArray[np.float64]
    twists: NDArray[np.float64]
    coupling_wrenches: NDArray[np.float64]
    feedback_wrenches: NDArray[np.float64]
    contact_wrenches: NDArray[np.float64]
    joint_wrenches: NDArray[np.float64]
    target_positions: NDArray[np.float64]
    target_quaternions: NDArray[np.float64]
    joint_coordinates: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.t)


class Scene(Session):
    """A scene and its session on the simulated clock; equal calls give equal bits, those of `godobject run --fast`.

    >>> scene = Scene("sim/scenes/wall.toml")
    >>> scene.bodies, scene.step_s
    (['peg'], 0.001)
    >>> scene.step(100)
    >>> scene.positions.shape, scene.quaternions.shape, scene.twists.shape
    ((1, 3), (1, 4), (1, 6))

    World frame, SI units, quaternions w, x, y, z. A row of each array is a body in the order of `bodies`:
    positions, quaternions; twists: velocity, angular velocity; wrenches: force, torque (docs/scenes.md, Trace).
    The arrays are read-only views of the scene's memory: they show the state after the latest call of step(), run()
    or reset(). Copy an array to keep a state.

    >>> before = scene.positions.copy()
    >>> now = scene.positions
    >>> scene.step()
    >>> now is not before and bool((now == scene.positions).all())
    True

    bus: "sim": the scene's device, simulated; "direct": none, the motion drives the core; None: as `godobject run`.
    on_fault: "raise": FaultError after the step in which a fault begins; "report": steps go on. `faults` has the
    name of each since the start, with the time when it first began; `limits` the number of steps of each limit.
    Raises SceneError, with all errors of the file and their places.
    """

    def __init__(self, path: str | os.PathLike[str], *, bus: str | None = None, on_fault: str = "raise",
                 _parts: dict[str, Any] | None = None):
        if bus not in (None, "sim", "direct"):
            raise ValueError(f"bus must be 'sim', 'direct' or None, not {bus!r}")
        if on_fault not in ("raise", "report"):
            raise ValueError(f"on_fault must be 'raise' or 'report', not {on_fault!r}")
        super().__init__(os.fspath(path), _parts, _plain, bus or "", on_fault == "raise")
        if _parts is None:
            _warn(Problem(*warning) for warning in self._warnings)

    @classmethod
    def from_dict(cls, scene: Mapping[str, Any], *, folder: str | os.PathLike[str] = ".", bus: str | None = None,
                  on_fault: str = "raise") -> "Scene":
        """Returns the scene of nested dicts with the keys of docs/scenes.md, as tomllib reads them from a file.

        folder: of the files that the scene names. Errors name the key:

        >>> import tomllib
        >>> with open("sim/scenes/wall.toml", "rb") as file:
        ...     parts = tomllib.load(file)
        >>> parts["body"][0]["mass"] = -1
        >>> Scene.from_dict(parts)
        Traceback (most recent call last):
        godobject.errors.SceneError: body[0].mass: 'mass' is -1, out of range: ...
        """
        name = os.path.join(os.fspath(folder), "<dict>")
        parts = dict(scene)
        try:
            made = cls(name, bus=bus, on_fault=on_fault, _parts=parts)
        except SceneError as error:
            if error.key is not None:
                raise
            keys = keys_of_dict(parts, name, _plain)
            raise SceneError([_with_key(problem, keys) for problem in error.problems]) from None
        if made._warnings:
            keys = keys_of_dict(parts, name, _plain)
            _warn(_with_key(Problem(*warning), keys) for warning in made._warnings)
        return made

    def reset(self, motion: str | os.PathLike[str] | ArrayLike | None = None) -> None:
        """Returns to t = 0. motion: as in run()."""
        if motion is None:
            self._reset(None, "")
        elif isinstance(motion, (str, os.PathLike)):
            _warn(self._reset(None, os.fspath(motion)))
        else:
            _warn(self._reset(self._table(motion), "<array>"))

    def step(self, n: int = 1) -> None:
        """Takes n steps, without the interpreter's lock. Raises FaultError."""
        if n < 0:
            raise ValueError(f"n must be 0 or more, not {n}")
        self._step(n, 0)

    @overload  # overlaps with the other, since an int may be 0
    def run(self, motion: str | os.PathLike[str] | ArrayLike | None = None, *,  # type: ignore[misc]
            duration: float | None = None, every: Literal[0]) -> None: ...

    @overload
    def run(self, motion: str | os.PathLike[str] | ArrayLike | None = None, *, duration: float | None = None,
            every: int = 1) -> Rows: ...

    def run(self, motion: str | os.PathLike[str] | ArrayLike | None = None, *, duration: float | None = None,
            every: int = 1) -> Rows | None:
        """Runs from t = 0 to the end of the motion, or for a duration in s. Returns the start and every n-th state.

        motion: a CSV file, as of `run --motion`; or an (N, 1 + 7 k) array of t and, for each of the k `targets`,
        x, y, z, qw, qx, qy, qz (admittance devices: (N, 1 + 6 k): fx, fy, fz, tx, ty, tz); None: the scene's own.
        every: 0: none, the scene has the end. Raises MotionError, FaultError.

        >>> rows = Scene("sim/scenes/wall.toml").run(duration=0.5, every=10)
        >>> rows.positions.shape
        (51, 1, 3)
        """
        if every < 0:
            raise ValueError(f"every must be 0 or more, not {every}")
        self.reset(motion)
        rows = self._step(self._num_steps(duration), every)
        return Rows(**rows) if every else None

    @property
    def contacts(self) -> Contacts:
        """The contacts that bear a force now."""
        return Contacts(**self._contacts())

    def _table(self, motion: ArrayLike) -> str:
        table = np.asarray(motion, dtype=np.float64)
        for suffixes in (_POSE, _WRENCH):
            columns = ["t", *(f"{target}.{suffix}" for target in self.targets for suffix in suffixes)]
            if table.ndim == 2 and table.shape[1] == len(columns):
                break
        else:
            raise MotionError([Problem(f"the array has the shape {table.shape}; give (N, {1 + 7 * len(self.targets)}): t, "
                                       f"and x, y, z, qw, qx, qy, qz of {', '.join(self.targets)}", "<array>")])
        text = io.StringIO()
        text.write(",".join(columns) + "\n")
        for row in table.tolist():
            text.write(",".join(map(repr, row)) + "\n")
        return text.getvalue()

    def __repr__(self) -> str:
        return f"<Scene {self.name}: {len(self.bodies)} bodies, t = {self.t:g} s>"


def _plain(value: Any) -> Any:
    """Returns arrays, paths and mappings as values of Python's own types, and others as they are."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, pathlib.PurePath):
        return str(value)
    return dict(value) if isinstance(value, Mapping) else value


def _with_key(problem: Problem, keys: list[str]) -> Problem:
    """Returns the problem with its key in place of line and column, which are those of a text made from dicts.

    Problems of a file that the scene names keep their place.
    """
    if not problem.file.endswith("<dict>"):
        return problem
    key = keys[problem.line - 1] if problem.line and problem.line <= len(keys) else ""
    return Problem(problem.message, problem.file, key=key)


def _warn(advice: Iterable[Problem | str]) -> None:
    for one in advice:
        warnings.warn(str(one), SceneWarning, stacklevel=3)
