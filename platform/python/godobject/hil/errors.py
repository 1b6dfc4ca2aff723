"""Exceptions of godobject.hil: each has the failure, its place and the remedy."""
from __future__ import annotations


class HilError(Exception):
    """Base of all exceptions of this package.

    text: the failure. where: program, bus, file or line. remedy: the next thing to do; empty if there is none.
    """

    def __init__(self, text: str, where: str = "", remedy: str = "") -> None:
        self.text, self.where, self.remedy = text, where, remedy
        super().__init__(f"{where}: {text}" * bool(where) + text * (not where) + f"\n  remedy: {remedy}" * bool(remedy))


class NotAvailable(HilError):
    """This machine or this rig lacks something: AF_CAN, an interface, a simulator. pytest skips the test."""


class Refused(HilError, AssertionError):
    """A program refused a command or a scene, and explained the reason."""


class Ended(HilError, AssertionError):
    """A program ended by itself, or did not start."""


class TimedOut(HilError, AssertionError):
    """A condition did not become true in time."""


class Late(HilError, AssertionError):
    """A motor had torque for longer than permitted. moment_wall_s: beginning of that time, s since 1970."""

    def __init__(self, text: str, where: str, remedy: str, moment_wall_s: float) -> None:
        super().__init__(text, where, remedy)
        self.moment_wall_s = moment_wall_s


class Expected(HilError, AssertionError):
    """An expectation of a test does not hold, or it would prove nothing."""
