"""A device of your own: poses of a hand to `godobject run --device SOCKET`, and the wrench to display.

    class MyDevice(Device):
        def read(self) -> Pose: return Pose(p_m=(0, 0, 0.01))
        def show(self, wrench: Wrench) -> None: print(wrench.f_N)

    MyDevice().run("/tmp/hand.sock")

World frame, SI units, quaternions w, x, y, z. The force must end with the program: `show` gets a wrench of zero once
none has arrived for 20 ms, and when the run ends.
"""
import dataclasses
import select
import socket
import struct
import time

Vector = tuple[float, float, float]

POSE = struct.Struct("<IId3d4dII")  # platform/linux/socket_device.h
WRENCH = struct.Struct("<IId3d3dII")
POSE_MAGIC, WRENCH_MAGIC = 0x31534447, 0x31574447
CLUTCH_OPEN, BUTTON, NOT_VALID, LIVE = 1, 2, 4, 1
SILENT_S = 0.02  # without a wrench, after which the force ends


@dataclasses.dataclass
class Pose:
    """The hand's pose in the world. `valid=False` where the device does not know it: the pose is then held.

    t_s: time of measurement, time.monotonic(); None: that of sending it.
    """
    p_m: Vector
    q_wxyz: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    clutch_open: bool = False
    button: bool = False  # grips the nearest body, or releases
    valid: bool = True
    t_s: float | None = None


@dataclasses.dataclass
class Wrench:
    """Force on the hand, and torque about the origin of its pose. Not `live`: zero after trouble of the run."""
    f_N: Vector = (0.0, 0.0, 0.0)
    tau_Nm: Vector = (0.0, 0.0, 0.0)
    t_s: float = 0.0  # time of the run
    live: bool = False


class Device:
    rate_hz = 1000.0

    def read(self) -> Pose:
        """Returns the newest pose of the hand."""
        raise NotImplementedError

    def show(self, wrench: Wrench) -> None:
        """Displays the wrench to the hand; called with the newest one."""

    def run(self, path: str, duration_s: float = float("inf"), patience_s: float = 10.0) -> None:
        """Serves the run on this socket until it ends, or for a time. Raises OSError if none is there in patience_s."""
        with connected(path, patience_s) as run:
            try:
                self._serve(run, duration_s)
            finally:
                self.show(Wrench())

    def _serve(self, run: socket.socket, duration_s: float) -> None:
        start = due = heard = time.monotonic()
        number, silent = 0, True
        while time.monotonic() - start < duration_s:
            number += 1
            pose = self.read()
            flags = CLUTCH_OPEN * pose.clutch_open | BUTTON * pose.button | NOT_VALID * (not pose.valid)
            t_s = time.monotonic() if pose.t_s is None else pose.t_s
            try:
                run.send(POSE.pack(POSE_MAGIC, number, t_s, *pose.p_m, *pose.q_wxyz, flags, 0))
            except BlockingIOError:
                pass  # the run is behind: this pose is left out
            except (BrokenPipeError, ConnectionResetError):
                return
            due = max(due + 1 / self.rate_hz, time.monotonic() - 0.1)
            while True:
                wrench, ended = newest(run)
                if ended:
                    return
                if wrench is not None:
                    heard, silent = time.monotonic(), False
                    self.show(wrench)
                elif not silent and time.monotonic() - heard > SILENT_S:
                    silent = True
                    self.show(Wrench())
                left = due - time.monotonic()
                if left <= 0:
                    break
                select.select([run], [], [], left)


def newest(run: socket.socket) -> tuple[Wrench | None, bool]:
    """Returns the newest wrench that has arrived or None, and whether the run has ended."""
    wrench = None
    while True:
        try:
            packet = run.recv(256)
        except BlockingIOError:
            return wrench, False
        except ConnectionResetError:
            return wrench, True
        if not packet:
            return wrench, True
        magic, _, t_s, fx, fy, fz, tx, ty, tz, flags, _ = WRENCH.unpack(packet)
        if magic != WRENCH_MAGIC:
            raise OSError("the socket is not that of `godobject run --device`, or of another version")
        wrench = Wrench((fx, fy, fz), (tx, ty, tz), t_s, bool(flags & LIVE))


def connected(path: str, patience_s: float) -> socket.socket:
    """Returns a connection to the run, which may still be starting."""
    end = time.monotonic() + patience_s
    while True:
        run = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        try:
            run.connect(path)
            run.setblocking(False)
            return run
        except (FileNotFoundError, ConnectionRefusedError) as error:
            run.close()
            if time.monotonic() > end:
                raise OSError(f"no run has made {path}: start `godobject run SCENE --device {path}`") from error
            time.sleep(0.05)
