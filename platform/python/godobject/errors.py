"""Exceptions of godobject."""
import dataclasses
from collections.abc import Iterable, Sequence
from typing import Any


@dataclasses.dataclass(frozen=True)
class Problem:
    """One error of a scene, motion or file. line, column: from 1; None: of the whole.

    key: of a scene from dicts, e.g. "body[0].coupling.stiffness".
    """
    message: str
    file: str
    line: int | None = None
    column: int | None = None
    key: str | None = None

    def __str__(self) -> str:
        if self.key is not None:
            return f"{self.key}: {self.message}" if self.key else self.message
        place = "".join(f":{number}" for number in (self.line, self.column) if number)
        return f"{self.file}{place}: {self.message}"


class InputError(ValueError):
    """A scene, motion or file is refused. `problems`: all errors; the other attributes are those of the first."""

    def __init__(self, problems: Iterable[Problem | Sequence[Any]]):
        self.problems = tuple(p if isinstance(p, Problem) else Problem(*p) for p in problems)
        first = self.problems[0]
        self.message, self.file, self.line, self.column, self.key = (
            first.message, first.file, first.line, first.column, first.key)
        super().__init__("\n".join(map(str, self.problems)))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.problems,)


class SceneError(InputError):
    """The scene is refused."""


class MotionError(InputError):
    """The motion is refused. Of an array: line 1 is that of the columns' names, line 2 the first row."""


class ReadError(InputError):
    """A trace, recording or report cannot be read."""


class FaultError(RuntimeError):
    """Faults began in a step. The scene shows the state after it, and can be stepped further.

    faults: their names, as of `godobject faults`. t: time of the step, s. remedies: one for each.
    """

    def __init__(self, t: float, texts: Iterable[Sequence[str]]):
        self.t, self.texts = t, tuple(tuple(text) for text in texts)
        self.faults = tuple(name for name, _, _ in self.texts)
        self.remedies = tuple(remedy for _, _, remedy in self.texts)
        super().__init__("\n".join(f"{name} at t = {t:g} s: {meaning}; {remedy}" for name, meaning, remedy in self.texts))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.t, self.texts)


class SceneWarning(UserWarning):
    """Advice on a scene that is accepted."""
