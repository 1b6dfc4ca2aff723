"""Clocks of a test: this process, the simulated rig, the bus, trace and report of a run."""
from __future__ import annotations

import dataclasses
import time

_WALL_AT_ZERO_S = time.time() - time.monotonic()


def now() -> float:
    """Returns the time of day, s since 1970. It does not jump when the system's clock is set, as in godobject."""
    return _WALL_AT_ZERO_S + time.monotonic()


@dataclasses.dataclass(frozen=True)
class Clock:
    """Map between the time of a program and the time of day. Both count seconds at one rate.

    zero_wall_s: time of day at its zero, s since 1970. error_s: bound of the error of that time, s.
    """
    zero_wall_s: float
    error_s: float

    def to_wall(self, t_s: float) -> float:
        """Returns the time of day of t_s, s since 1970."""
        return self.zero_wall_s + t_s

    def from_wall(self, wall_s: float) -> float:
        """Returns the time of this clock at a time of day, s."""
        return wall_s - self.zero_wall_s


@dataclasses.dataclass(frozen=True)
class Moment:
    """An event of a test: a fault of the rig, a signal, an observed frame.

    wall_s: time of day, s since 1970. error_s: bound of its error, s. text: the event, for messages.
    rig_s: its time on the rig's clock, s, where the rig itself has measured it.
    """
    wall_s: float
    error_s: float = 0.0
    text: str = "the event"
    rig_s: float | None = None


def moment(text: str) -> Moment:
    """Returns the present moment."""
    return Moment(now(), text=text)
