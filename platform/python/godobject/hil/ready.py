"""Readiness of a program under test: all drives of the scene are enabled."""
from __future__ import annotations

import re
from collections.abc import Mapping

from .errors import TimedOut
from .ports import Listener, wait_for
from .programs import Process
from .scene import Scene

_ENABLED = ("operation enabled", "8")  # CiA 402; axis state of an ODrive
_STATUS_LINE = re.compile(r"^t +\d", re.M)  # of a run, each second


def wait_until_enabled(scene: Scene, listeners: Mapping[str, Listener], program: Process, timeout_s: float,
                       marks: Mapping[str, int]) -> None:
    """Waits as Rig.wait_until_enabled(), or until the program ends."""
    drives = {(node.bus, node.node_id) for node in scene.drives if node.protocol != "moteus"}
    waits_for_line = not drives and not scene.has_sync or any(n.protocol == "moteus" for n in scene.drives)
    since = dict(marks)
    states: dict[tuple[str, int], str] = {}

    def enabled() -> bool:
        for name, listener in listeners.items():
            new = listener.since(since.get(name, 0))
            since[name] = since.get(name, 0) + len(new)
            for message in map(scene.decode, new):
                state = str(message.values.get("state", message.values.get("axis_state", "")))
                if message.node and message.node.kind == "drive" and state:
                    states[name, message.node.node_id] = state
                elif message.name == "SYNC":
                    states[name, 0] = message.name
        if waits_for_line and not _STATUS_LINE.search(program.error_text()):
            return False
        return all(states.get(drive) in _ENABLED for drive in drives) and (bool(states) or waits_for_line)

    try:
        wait_for(lambda: enabled() or not program.running, timeout_s, "every drive in operation enabled")
    except TimedOut:
        reached = ", ".join(f"{bus} node {node} {states.get((bus, node), 'silent')}" for bus, node in sorted(drives))
        raise TimedOut(f"not enabled within {timeout_s:g} s: {reached}", program.name,
                       "see error_text() of the program and frames_text() of the rig") from None
