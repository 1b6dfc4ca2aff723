#!/usr/bin/env python3
"""Runs the example on a rig that is simulated at the other end of pseudo-terminals.

usage: peg_on_rig.py GODOBJECT SCENE EXAMPLE
"""
import subprocess
import sys

from simulated_rig import simulated_rig

RUN_S = 60


def main():
    program, scene, example = sys.argv[1:]
    with simulated_rig(program, scene) as addresses:
        buses = [f"{bus}={address}" for bus, address in addresses.items()]
        result = subprocess.run([example, scene, *buses], text=True, capture_output=True, timeout=RUN_S)
    print(result.stdout + result.stderr)
    return result.returncode


if __name__ == "__main__":
    sys.exit(main())
