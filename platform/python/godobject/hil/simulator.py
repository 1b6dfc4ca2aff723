"""`godobject simulate` with commands on its standard input."""
from __future__ import annotations

import json
import os
import select
import subprocess
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from .errors import Ended, NotAvailable, Refused, TimedOut
from .programs import Process
from .scene import Scene

_ANSWER_S = 30.0  # for an answer of the simulator, which steps first


class Simulator(Process):
    """`godobject simulate`, with commands on its standard input."""

    def __init__(self, scene: Scene, arguments: Sequence[str | Path]) -> None:
        super().__init__([scene.program, "simulate", scene.path, "--control", "-", *arguments], stdin=subprocess.PIPE,
                         stdout=subprocess.PIPE, bufsize=0)
        self.buses: dict[str, str] = {}
        self.taps: dict[str, str] = {}
        self.trackers: dict[str, str] = {}
        self._text = b""
        kinds = {"bus": self.buses, "tap": self.taps, "tracker": self.trackers}
        try:
            while (line := self._line()) != "ready":
                kind, name, where = line.split(maxsplit=2)
                kinds[kind][name.rstrip(":")] = where.split()[-1]
        except BaseException:
            self.close()
            raise

    def _line(self) -> str:
        assert self.popen.stdout is not None
        end = time.monotonic() + _ANSWER_S
        while b"\n" not in self._text:
            ready = select.select([self.popen.stdout], [], [], max(0.0, end - time.monotonic()))[0]
            if not ready:
                raise TimedOut(f"no answer within {_ANSWER_S:g} s", self.name, "see its standard error:\n" + self.error_text())
            read = os.read(self.popen.stdout.fileno(), 65536)
            if not read:
                self.wait()
                kind = NotAvailable if self.exit_code == 3 else Refused if self.exit_code == 2 else Ended
                raise kind(self.error_text().strip() or f"exit code {self.exit_code}", " ".join(self.command))
            self._text += read
        line, _, self._text = self._text.partition(b"\n")
        return line.decode().strip()

    def command_line(self, line: str) -> dict[str, Any]:
        assert self.popen.stdin is not None
        try:
            self.popen.stdin.write((line + "\n").encode())
        except OSError:
            raise Ended("the simulated rig has ended", self.name, "see its standard error:\n" + self.error_text()) from None
        reply: dict[str, Any] = json.loads(self._line())
        if not reply.get("ok"):
            raise Refused(str(reply.get("error")), line, "verbs and keys: docs/faults.md")
        return reply
