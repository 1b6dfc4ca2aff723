"""The rig of a scene: simulated on pseudo-terminals, vcan or given interfaces, or real."""
from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

from . import frames
from .clocks import Clock, Moment, now
from .errors import Ended, Expected, HilError, Late, NotAvailable, Refused
from .frames import Frame
from .ports import Listener, open_port, wait_for
from .programs import Process, Run
from .ready import wait_until_enabled
from .scene import Scene
from .simulator import Simulator

ATTEMPTS = 4  # of a start that a busy machine has stalled
_SILENCE_S = 0.15


class Rig:
    """Encoders and drives of a scene, and a listener on each of its buses.

    A context manager: all programs that it started end with it, also on an exception.

    scene: path, or Scene. buses: "pty": pseudo-terminals; "vcan": the first bus on vcan0, the next on vcan1, ...;
    or the SocketCAN interface of each bus by name. simulated: False for a real rig on these interfaces.
    motion: CSV that the simulated hand follows; None: the scene's own. folder: of the files of runs; None: temporary.
    """

    def __init__(self, scene: str | Path | Scene, *, program: str | Path | None = None,
                 buses: str | Mapping[str, str] = "pty", simulated: bool = True, motion: str | Path | None = None,
                 folder: str | Path | None = None, arguments: Sequence[str | Path] = ()) -> None:
        self.scene = scene if isinstance(scene, Scene) else Scene(scene, program)
        self._resources = contextlib.ExitStack()
        self.programs: list[Process] = []  # started on this rig
        try:
            self.folder = Path(folder) if folder else Path(self._resources.enter_context(
                tempfile.TemporaryDirectory(prefix="godobject-rig-")))
            self._simulator: Simulator | None = None
            self.addresses: dict[str, str] = {}
            self.trackers: dict[str, str] = {}
            listened = self._open(buses, simulated, motion, arguments)
            self.listeners: dict[str, Listener] = {}
            for name, address in listened.items():
                listener = Listener(name, open_port(address), self.scene.is_canopen(name))
                self._resources.callback(listener.close)
                self.listeners[name] = listener
            self._clock: tuple[Clock, float] | None = None  # measured, and held_s then
        except BaseException:
            self.close()
            raise

    def _open(self, buses: str | Mapping[str, str], simulated: bool, motion: str | Path | None,
              arguments: Sequence[str | Path]) -> dict[str, str]:
        words: list[str | Path] = [*arguments, *(["--motion", motion] if motion else [])]
        if self.scene.buses and not self.scene.has_sync:
            words.append("--start-now")  # the hand would wait for a SYNC
        if buses == "pty":
            if not simulated:
                raise HilError("a real rig is on no pseudo-terminal", "buses", "give the interface of each bus by name")
            words += ["--bus", "pty", "--tap", "pty"] * bool(self.scene.buses)
            # A real-time priority, otherwise answers are late on a busy machine.
            simulator = self._simulate([*words, "--realtime"])
            self.addresses = {name: f"slcan:{path}" for name, path in simulator.buses.items()}
            return {name: f"slcan:{path}" for name, path in simulator.taps.items()}
        if isinstance(buses, str):
            if buses != "vcan":
                raise HilError(f"no kind of buses {buses!r}", "buses", 'give "pty", "vcan", or the interface of each bus')
            buses = {name: f"vcan{i}" for i, name in enumerate(self.scene.buses)}
        missing, unknown = set(self.scene.buses) - set(buses), set(buses) - set(self.scene.buses)
        if missing or unknown:
            raise HilError(f"buses without an interface: {sorted(missing)}, unknown ones: {sorted(unknown)}", self.scene.path,
                           "give the interface of each bus of the scene by name")
        self.addresses = {name: f"socketcan:{interface}" for name, interface in buses.items()}
        if simulated:
            # Not --realtime, otherwise the listener gets no time in a guest with one processor.
            self._simulate([*words, *(word for name, at in self.addresses.items() for word in ("--bus", f"{name}={at}"))])
        return dict(self.addresses)

    def _simulate(self, arguments: Sequence[str | Path]) -> Simulator:
        self._simulator = Simulator(self.scene, arguments)
        self._resources.callback(self._simulator.close)
        self.trackers = self._simulator.trackers
        return self._simulator

    @property
    def is_simulated(self) -> bool:
        """True if this rig plays faults and measures torque."""
        return self._simulator is not None

    @property
    def simulator(self) -> Process:
        """The program that simulates the rig. Raises NotAvailable on a real one."""
        return self._simulation()

    def _simulation(self) -> Simulator:
        if self._simulator is None:
            raise NotAvailable("plays faults and measures torque: only on a simulated rig", self.scene.path)
        return self._simulator

    @property
    def bus(self) -> Listener:
        """Listener on the scene's first bus."""
        return self.listeners[self.scene.buses[0]]

    def address(self, bus: str = "") -> str:
        """Returns the address of a bus for the program under test, as slcan:/dev/pts/3; default: the first bus."""
        return self.addresses[bus or self.scene.buses[0]]

    def terminal(self, bus: str = "") -> str:
        """Returns the path of a bus's pseudo-terminal, on which a program may speak SLCAN; default: the first bus."""
        kind, _, path = self.address(bus).partition(":")
        if kind != "slcan":
            raise HilError(f"bus {bus or self.scene.buses[0]} is at {kind}:{path}", self.scene.path, 'make the rig with buses="pty"')
        return path

    # Programs

    def start(self, command: Sequence[str | Path], **popen: Any) -> Process:
        """Starts a program under test, a master of your own; it ends with the rig. popen: as of subprocess.Popen."""
        process = Process(command, **popen)
        self.programs.append(process)
        return process

    def start_run(self, *arguments: str | Path, record: bool = True, trace: bool = False, **popen: Any) -> Run:
        """Starts `godobject run` on this rig; it ends with the rig. arguments: further ones of `run`.

        record, trace: writes these files into the rig's folder; a scene without buses has no record.
        """
        run = Run(self.scene.program, self.scene.path, [f"{name}={at}" for name, at in self.addresses.items()], self.folder,
                  arguments, [f"{name}={port}" for name, port in self.trackers.items()],
                  record and bool(self.scene.buses), trace, **popen)
        self.programs.append(run)
        return run

    @property
    def runs(self) -> list[Run]:
        """Runs that were started on this rig."""
        return [program for program in self.programs if isinstance(program, Run)]

    def end_programs(self) -> None:
        """Ends all programs that were started on this rig, the last first; the rig goes on."""
        for program in reversed(self.programs):
            program.close()

    def run_enabled(self, *arguments: str | Path, timeout_s: float = 15.0, record: bool = True, trace: bool = False) -> Run:
        """Starts `godobject run` and waits until every drive is enabled; again if a busy machine has stalled the start."""
        for _ in range(ATTEMPTS):
            marks, held_s = self.marks(), self.held_s()
            run = self.start_run(*arguments, record=record, trace=trace)
            if self.wait_until_enabled(run, timeout_s, marks):
                return run
            is_stalled = (self.held_s() > held_s + 4 * self.scene.step_s or
                          (run.report_path.exists() and run.was_starved()))
            if not is_stalled:
                break
        if not run.report_path.exists():
            raise Refused(run.error_text().strip() or f"exit code {run.exit_code}", " ".join(run.command))
        raise Ended(f"godobject run has ended:\n{run.error_text()}\n{run.fault_text()}", self.scene.path,
                    "end other load on this machine" if is_stalled else "godobject faults explains each fault")

    def marks(self) -> dict[str, int]:
        """Returns a position in the frames of each bus, as Listener.mark()."""
        return {name: listener.mark() for name, listener in self.listeners.items()}

    def wait_until_enabled(self, program: Process, timeout_s: float = 15.0, marks: Mapping[str, int] | None = None) -> bool:
        """Waits until every drive is enabled (CiA 402: operation enabled; ODrive: axis state 8); returns False if the program
        ends by itself before.

        marks: frames before them do not count. A scene without drives is ready with its first SYNC, one with moteus drives
        or without SYNC with the first status line of the run, not with --quiet. Raises TimedOut after timeout_s, s.
        """
        wait_until_enabled(self.scene, self.listeners, program, timeout_s, marks or {})
        return program.running

    # Faults and torque of a simulated rig

    def fault(self, verb: str, *, joint: str = "", bus: str = "", node: int | None = None, tracker: str = "",
              value: float | None = None, duration: float | None = None) -> Moment:
        """Injects a fault and returns its moment on the rig's clock.

        verb: one of drop, duplicate, delay, corrupt, stuck, spike, wrap, nan, reboot-node, emcy, bus-off, restart, unplug,
        id-collision, clock-drift, swap-ids, second-host, flood, press, missing, disabled (docs/faults.md); or a whole line,
        such as "drop bus=can0 node=4 value=0.1". value: in the verb's unit. duration: s; None: to the end, or once.
        joint: its encoder, else its drive, in place of bus and node. Raises Refused with the simulator's reason.
        """
        words = [verb]
        if joint:
            place = next((n for n in self.scene.nodes.values() if n.joint == joint), None) or self.scene.node(joint)
            bus, node = place.bus, place.node_id
        given = {"bus": bus or None, "node": node, "tracker": tracker or None, "value": value, "duration": duration}
        words += [f"{key}={word}" for key, word in given.items() if word is not None]
        line = "fault " + " ".join(words)
        t_s = float(self._simulation().command_line(line)["t_s"])
        clock = self.clock
        return Moment(clock.to_wall(t_s), clock.error_s, " ".join(words), t_s)

    def clear(self) -> None:
        """Ends all faults, and cancels those that wait."""
        self._simulation().command_line("clear")

    def recover(self) -> None:
        """Ends all faults and restarts controllers that went bus-off, so that a later run can boot every node."""
        self.clear()
        for bus in self.scene.buses:
            self.fault("restart", bus=bus)
        for node in self.scene.nodes.values():
            self.fault("restart", bus=node.bus, node=node.node_id)

    def status(self) -> dict[str, Any]:
        """Returns `status` of the simulator: t_s, held_s, motion_s, buses, drives (torque_Nm, nonzero_at_s), faults, ..."""
        return self._simulation().command_line("status")

    @property
    def clock(self) -> Clock:
        """Clock of the simulated rig, t_s of status(). It stands still while the simulator is held up, which is
        measured (held_s of status()) and part of error_s."""
        if self._clock is None:
            self.measure_clock()
        assert self._clock is not None
        clock, held_s = self._clock
        return Clock(clock.zero_wall_s, clock.error_s + self.held_s() - held_s)

    def measure_clock(self) -> None:
        """Measures `clock` again, so that earlier holds add nothing to its error."""
        best: tuple[Clock, float] | None = None
        for _ in range(5):  # of several round trips the shortest
            sent = now()
            status = self.status()
            received = now()
            clock = Clock((sent + received) / 2 - float(status["t_s"]), (received - sent) / 2)
            if best is None or clock.error_s < best[0].error_s:
                best = clock, float(status["held_s"])
        self._clock = best

    def held_s(self) -> float:
        """Returns the time, s, for which a busy machine has held the simulator up; 0 on a real rig."""
        return float(self.status()["held_s"]) if self.is_simulated else 0.0

    def torque_Nm(self, joint: str = "") -> float:
        """Returns the largest absolute torque of the motors, or of a joint's, N m."""
        return max((abs(d["torque_Nm"]) for d in self.status()["drives"] if joint in ("", d["joint"])), default=0.0)

    def wait_for_torque(self, above_Nm: float = 0.0, timeout_s: float = 10.0, joint: str = "") -> None:
        """Waits until a motor has more torque, N m. Before a fault: motors that had none prove nothing."""
        wait_for(lambda: self.torque_Nm(joint) > above_Nm, timeout_s, f"torque above {above_Nm:g} N m")

    def wait_for_zero_torque(self, timeout_s: float, joint: str = "") -> None:
        """Waits until no motor has torque."""
        wait_for(lambda: self.torque_Nm(joint) == 0, timeout_s, "torque zero")

    def wait_until(self, t_s: float, timeout_s: float = 10.0) -> dict[str, Any]:
        """Waits until the rig's clock has passed t_s, s; returns its status then."""
        return wait_for(lambda: s if (s := self.status())["t_s"] > t_s else {}, timeout_s + max(0.0, t_s - self.status()["t_s"]),
                        f"{t_s:g} s on the rig's clock")

    def assert_zero_torque(self, after: Moment, within_s: float, for_s: float = 0.2, joint: str = "") -> float:
        """Asserts that every motor, or that of a joint, has no torque from `after` + within_s on; observes for_s longer.

        Returns the time from `after` to the last torque, s. Measured on the rig's clock, so this process may be late.
        Where `after` is of another clock, its error is added to within_s. Raises Late; AssertionError if no motor had
        torque in the second before `after`, since that would prove nothing.
        """
        __tracebackhide__ = True
        t_s = after.rig_s if after.rig_s is not None else self.clock.from_wall(after.wall_s)
        error_s = 0.0 if after.rig_s is not None else after.error_s + self.clock.error_s
        drives = [d for d in self.wait_until(t_s + within_s + for_s)["drives"] if joint in ("", d["joint"])]
        last = max(drives, key=lambda d: float(d["nonzero_at_s"]), default=None)
        if last is None or not max(0.0, t_s - 1.0) < last["nonzero_at_s"]:  # 0: never
            raise Expected("no motor had torque in the second before it: this proves nothing", after.text,
                               "wait_for_torque() first")
        took_s = float(last["nonzero_at_s"]) - t_s
        if took_s > within_s + error_s:
            raise Late(f"{last['joint']} ({last['bus']} node {last['node']}) had torque for {1e3 * took_s:.1f} ms, "
                       f"permitted are {1e3 * within_s:.1f} ms", after.text, "see frames_text()", after.wall_s)
        return max(0.0, took_s)

    # Observation of the buses

    def decode(self, frame: Frame) -> str:
        """Returns a frame as text, with names and units of the scene."""
        return str(self.scene.decode(frame))

    def value(self, key: str, joint: str, kind: str = "drive") -> Any:
        """Returns the newest value of a joint's drive or encoder: "torque_Nm", "position_rad", "state", ... of decode()."""
        node = self.scene.node(joint, kind)
        keys: set[str] = set()
        for message in map(self.scene.decode, reversed(self.listeners[node.bus].frames)):
            if message.node is node and not message.name.endswith("torque command"):
                if key in message.values:
                    return message.values[key]
                keys |= message.values.keys()
        raise HilError(f"no frame with {key}", f"{node.bus} node {node.node_id}, {kind} of {joint}",
                       f"its frames have {', '.join(sorted(keys))}: `check --full` prints what its profile maps" if keys
                       else "wait until it sends")

    def frames_text(self, around_wall_s: float | None = None, before_s: float = 0.5, after_s: float = 0.5,
                    most: int = 60) -> str:
        """Returns the decoded frames of all buses around a time of day, default: now; ms are relative to it.

        most: number of frames, the nearest ones. before_s, after_s: bounds of their time, s.
        """
        around = now() if around_wall_s is None else around_wall_s
        found = sorted((f for listener in self.listeners.values() for f in listener.between(around - before_s, around + after_s)),
                       key=lambda f: f.time)
        left_out = len(found) - most
        nearest = sorted(sorted(found, key=lambda f: abs(f.time - around))[:most], key=lambda f: f.time)
        lines = [f"{1e3 * (f.time - around):+9.2f} ms  {self.decode(f)}" for f in nearest]
        return "\n".join(lines + [f"{left_out} frames farther from it are left out"] * (left_out > 0)) or "no frames"

    def starved_by(self) -> str:
        """Returns how a busy machine has disturbed the runs of this rig; empty if it has not.

        A run reports missed deadlines, the simulator was held up for more than four periods, a bus has SYNCs more than
        four periods apart, or the simulated nodes, which send heartbeats each 0.1 s, were silent for longer than 0.15 s.
        """
        found = []
        with contextlib.suppress(HilError, OSError):
            if (held_s := self.held_s()) > 4 * self.scene.step_s:
                found.append(f"the simulator was held up for {1e3 * held_s:.0f} ms")
        for run in self.runs:
            if not run.running and run.report_path.exists():
                with contextlib.suppress(HilError, KeyError):
                    if missed := run.missed_deadlines():
                        found.append(f"{missed} deadlines missed")
        for name, listener in self.listeners.items():
            for wanted, received, most_s in (("a SYNC", listener.since(kind=frames.SYNC), 4 * self.scene.step_s),
                                             ("a frame", listener.frames, _SILENCE_S)):
                gap_s = max((b.time - a.time for a, b in zip(received, received[1:])), default=0.0)
                if gap_s > most_s and (self.is_simulated or wanted == "a SYNC"):
                    found.append(f"{1e3 * gap_s:.0f} ms without {wanted} on {name}")
        return ", ".join(found)

    # End

    def close(self) -> None:
        """Ends all programs that were started on this rig, its listeners, and its simulation."""
        try:
            self.end_programs()
        finally:
            self._resources.close()

    def __enter__(self) -> Rig:
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        self.close()
