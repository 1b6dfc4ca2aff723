"""Hardware-in-the-loop tests: a rig on a bus, the program under test, a listener on each bus.

    from godobject import hil

    with hil.Rig("my/needle-holder.toml") as rig:      # encoders, drives, mechanics and hand on pseudo-terminals
        run = rig.run_enabled()                        # godobject run, or rig.start([...]): a master of your own
        rig.wait_for_torque()
        unplugged = rig.fault("unplug", joint="roll")
        rig.assert_zero_torque(after=unplugged, within_s=0.2)
        run.wait_for_event("FAULT sample_stale", 1)

All units are SI and part of the name where they are not: s, N m, rad; times of day are s since 1970.
With pytest: `-p godobject.hil.pytest_plugin`. The page: docs/python-hil.md.
"""
from .clocks import Clock, Moment, moment, now
from .errors import Ended, Expected, HilError, Late, NotAvailable, Refused, TimedOut
from .frames import (DRIVE_STATES, EMCY, HEARTBEAT, NMT, NMT_COMMANDS, NMT_STATES, OTHER, RPDO1, RPDO2, RPDO3, RPDO4, SYNC,
                     TPDO1, TPDO2, TPDO3, TPDO4, Frame, drive_state, make_frame, read_candump, read_trace)
from .ports import Listener, Port, SlcanPort, SocketCanPort, open_port, wait_for, why_no_socketcan
from .programs import Process, Run, is_sanitized
from .rig import ATTEMPTS, Rig
from .scene import Message, Node, Scene, changed_scene, find_program

__all__ = [
    "ATTEMPTS", "Clock", "DRIVE_STATES", "EMCY", "Ended", "Expected", "Frame", "HEARTBEAT", "HilError", "Late", "Listener",
    "Message", "Moment", "NMT", "NMT_COMMANDS", "NMT_STATES", "Node", "NotAvailable", "OTHER", "Port", "Process", "RPDO1",
    "RPDO2", "RPDO3", "RPDO4", "Refused", "Rig", "Run", "SYNC", "Scene", "SlcanPort", "SocketCanPort", "TPDO1", "TPDO2",
    "TPDO3", "TPDO4", "TimedOut", "changed_scene", "drive_state", "find_program", "is_sanitized", "make_frame", "moment",
    "now", "open_port", "read_candump", "read_trace", "wait_for", "why_no_socketcan",
]
