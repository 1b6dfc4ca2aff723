#!/usr/bin/env python3
"""Runs the example on a rig that is simulated at the other end of pseudo-terminals.

usage: peg_on_rig.py GODOBJECT SCENE EXAMPLE
"""
import re
import subprocess
import sys

from simulated_rig import exit_code_unless_starved, simulated_rig

RUN_S = 60


def run(program, scene, example):
    with simulated_rig(program, scene) as addresses:
        buses = [f"{bus}={address}" for bus, address in addresses.items()]
        result = subprocess.run([example, scene, *buses], text=True, capture_output=True, timeout=RUN_S)
    print(result.stdout + result.stderr)
    return result.returncode, result.returncode != 0 and was_starved(result.stdout)


def was_starved(output):
    """True if the run has made steps and has missed deadlines: the machine left it without its processor."""
    made = re.search(r"(\d+) steps, (\d+) deadlines missed", output)
    return made is not None and int(made[1]) > 0 and int(made[2]) > 0


def main():
    return exit_code_unless_starved(lambda: run(*sys.argv[1:]))


if __name__ == "__main__":
    sys.exit(main())
