"""Programs that a test starts. Each ends with its test, whatever happens; no other program is ever signalled."""
from __future__ import annotations

import atexit
import contextlib
import ctypes
import json
import os
import re
import signal
import subprocess
import tempfile
import threading
import time
import weakref
from collections.abc import Callable, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

from .clocks import Clock, Moment, moment
from .errors import Ended, HilError
from .ports import wait_for

_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of Linux
_LIBC = ctypes.CDLL(None, use_errno=True)
_started: weakref.WeakSet[Process] = weakref.WeakSet()


class Process:
    """A program with its standard error in a file. A context manager; also ended when Python ends or is killed.

    command: program and arguments. popen: as of subprocess.Popen, in place of the defaults.
    """

    def __init__(self, command: Sequence[str | Path], **popen: Any) -> None:
        self.command = [str(word) for word in command]
        self._errors = tempfile.TemporaryFile()
        # The kernel sends this signal when the thread ends that has started the program, so only the main one may.
        orphaned = signal.SIGTERM if threading.current_thread() is threading.main_thread() else None
        before: Callable[[], None] | None = popen.pop("preexec_fn", None)

        def prepare() -> None:
            if orphaned is not None:
                _LIBC.prctl(_DEATH_SIGNAL, orphaned)
            if before is not None:
                before()

        options: dict[str, Any] = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": self._errors} | popen
        try:
            self.popen = subprocess.Popen(self.command, preexec_fn=prepare, **options)
        except OSError as error:
            raise Ended(error.strerror or str(error), self.command[0], "give the path of a program that can be run") from None
        _started.add(self)

    @property
    def running(self) -> bool:
        """True until the program has ended."""
        return self.popen.poll() is None

    @property
    def exit_code(self) -> int | None:
        """Exit code; minus the number of the signal that ended it; None while it runs."""
        return self.popen.poll()

    def send_signal(self, number: int) -> Moment:
        """Sends a signal and returns its moment."""
        sent = moment(f"{signal.Signals(number).name if number in set(signal.Signals) else number} to {self.name}")
        self.popen.send_signal(number)
        return sent

    @property
    def name(self) -> str:
        """Name of the program and its first argument, for messages."""
        return " ".join([Path(self.command[0]).name, *self.command[1:2]])

    def pause(self, seconds: float) -> None:
        """Stops the program for this time, s: a stall of its machine."""
        self.popen.send_signal(signal.SIGSTOP)
        try:
            time.sleep(seconds)
        finally:
            self.popen.send_signal(signal.SIGCONT)

    def wait(self, timeout_s: float = 10.0) -> int:
        """Returns the exit code. Raises Ended if the program still runs after timeout_s, s."""
        try:
            return self.popen.wait(timeout_s)
        except subprocess.TimeoutExpired:
            raise Ended(f"does not end within {timeout_s:g} s", " ".join(self.command), "see error_text()") from None

    def kill(self) -> Moment:
        """Kills the program, waits for its end and returns the moment of the signal."""
        killed = self.send_signal(signal.SIGKILL)
        self.popen.wait()
        return killed

    def stop(self, timeout_s: float = 10.0) -> int | None:
        """Sends SIGINT and returns the exit code; kills the program after timeout_s, s, and returns None."""
        if self.running:
            self.popen.send_signal(signal.SIGCONT)
            self.popen.send_signal(signal.SIGINT)
        try:
            return self.popen.wait(timeout_s)
        except subprocess.TimeoutExpired:
            self.kill()
            return None

    def error_text(self) -> str:
        """Returns the standard error so far."""
        size = os.fstat(self._errors.fileno()).st_size
        return os.pread(self._errors.fileno(), size, 0).decode(errors="replace")  # at its own position: the program writes

    def wait_for_text(self, pattern: str, timeout_s: float) -> re.Match[str]:
        """Returns the first match of a regular expression in the standard error; raises TimedOut after timeout_s, s."""
        search = re.compile(pattern, re.M)
        found = wait_for(lambda: search.search(self.error_text()), timeout_s, f"{pattern!r} on standard error of {self.name}")
        assert found is not None
        return found

    def close(self) -> None:
        """Ends the program."""
        if self.running:
            self.stop()
        for stream in (self.popen.stdin, self.popen.stdout):
            if stream is not None:
                with contextlib.suppress(OSError):
                    stream.close()

    def __enter__(self) -> Process:
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


@atexit.register
def _end_all() -> None:
    for process in list(_started):
        process.close()


_EVENT = re.compile(r"^at (\d+\.\d+) s: (.*)$", re.M)


class Run(Process):
    """`godobject run` on the buses of a rig.

    buses: NAME=ADDRESS of each. folder: of its files report.json, record.log (candump) and, with trace, trace.csv.
    arguments: further ones, such as "--rearm", "auto". popen: as of subprocess.Popen.
    """

    def __init__(self, program: str | Path, scene: str | Path, buses: Sequence[str], folder: str | Path,
                 arguments: Sequence[str | Path] = (), trackers: Sequence[str] = (), record: bool = True, trace: bool = False,
                 **popen: Any) -> None:
        self.folder = Path(folder)
        self.report_path = self.folder / "report.json"
        self.record_path, self.trace_path = self.folder / "record.log", self.folder / "trace.csv"
        self.report_path.unlink(missing_ok=True)  # that of an earlier run
        words: list[str | Path] = [program, "run", scene, "--report", self.report_path]
        words += [word for bus in buses for word in ("--bus", bus)]
        words += [word for tracker in trackers for word in ("--tracker", tracker)]
        if record:
            words += ["--record", self.record_path]
        if trace:
            words += ["--trace", self.trace_path]
        super().__init__([*words, *arguments], **popen)

    def console(self) -> list[tuple[float, str]]:
        """Returns (t, text) of the events on standard error so far: s since the motion began, "FAULT sample_stale (...)"."""
        return [(float(t), text) for t, text in _EVENT.findall(self.error_text())]

    def wait_for_event(self, pattern: str, timeout_s: float) -> tuple[float, str]:
        """Returns (t, text) of the first event that matches a regular expression; raises TimedOut after timeout_s, s.

        Events: FAULT NAME, the device is lost, ARMED again, ...: docs/running.md.
        """
        found = wait_for(lambda: [event for event in self.console() if re.search(pattern, event[1])], timeout_s,
                         f"event {pattern!r} of {self.name}; events so far: {[text for _, text in self.console()]}")
        return found[0]

    def report(self) -> dict[str, Any]:
        """Returns the report of an ended run: docs/running.md."""
        try:
            report: dict[str, Any] = json.loads(self.report_path.read_text())
            return report
        except (OSError, ValueError) as error:
            raise Ended(f"no report: {error}\n{self.error_text()}", str(self.report_path), "stop() the run first") from None

    def faults(self) -> set[str]:
        """Returns the names of the faults of an ended run."""
        return {fault["name"] for fault in self.report()["faults"]}

    def fault_text(self) -> str:
        """Returns the faults of an ended run with their places, a line each."""
        return "\n".join(f"{fault['name']}: {fault['text']}" for fault in self.report()["faults"])

    def missed_deadlines(self) -> int:
        """Returns the missed deadlines of an ended run."""
        return int(self.report()["timing"]["missed_deadlines"])

    def clock(self) -> Clock:
        """Returns the clock of `t_s` in report and console of an ended run. `t_bus` of a trace is the time of day."""
        start = self.report()["motion_start_wall_s"]
        if start is None:
            raise HilError("no motion in wall time", str(self.report_path), "run on real buses, until the motion has begun")
        return Clock(start, 1e-4)

    def was_starved(self) -> bool:
        """True if the faults of an ended run are those of a stalling machine, without an injected fault.

        A drive then received no command for its `deadline_ms`, or the host no frame for `stale_after` or for the
        `heartbeat_timeout` of all nodes.
        """
        faults = self.faults()
        watchdog = faults == {"emergency"} and "0x8250" in self.fault_text()
        return watchdog or (bool(faults) and faults <= {"drive_silent", "sample_stale", "heartbeat_lost", "held"})


def is_sanitized(program: str | Path) -> bool:
    """True if the program has a sanitizer, which makes it several times slower and delays its end."""
    code = Path(program).read_bytes()
    return b"__tsan_init" in code or b"__asan_init" in code
