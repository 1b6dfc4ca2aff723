#!/usr/bin/env python3
"""Starts a rig by the installed module and the installed program.

usage: hil_from_prefix.py PREFIX SCENE; PYTHONPATH: the prefix's folder of Python modules
"""
import sys
from pathlib import Path

from godobject import hil


def main():
    prefix, scene = map(Path, sys.argv[1:])
    module = Path(hil.__file__)
    if not module.is_relative_to(prefix) or not (module.parent / "py.typed").exists():
        sys.exit(f"{module}: not the typed module of {prefix}")
    with hil.Rig(scene, program=prefix / "bin/godobject") as rig:
        heartbeat = rig.bus.wait_for(lambda f: f.kind == hil.HEARTBEAT, 5, "a heartbeat")
        print(rig.decode(heartbeat))


if __name__ == "__main__":
    main()
