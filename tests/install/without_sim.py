#!/usr/bin/env python3
"""Runs a scene with the program that has no simulated devices, on a rig that the full program simulates.

usage: without_sim.py GODOBJECT LIBGODOBJECT_SIM WITHOUT_SIM SCENE NM
"""
import subprocess
import sys

from simulated_rig import simulated_rig
from symbols import functions_of, symbols

RUN_S = 60


def main():
    full, library, without, scene, nm = sys.argv[1:]
    of_sim = functions_of(nm, library)
    if not of_sim & symbols(nm, full, "T", "--defined-only"):
        sys.exit("the full program has no symbol of the simulation: this says nothing")
    left = of_sim & symbols(nm, without, "TW", "--defined-only")
    if left:
        sys.exit(f"{len(left)} symbols of the simulation: {sorted(left)[:5]}")
    refused = subprocess.run([without, "run", scene, "--fast"], capture_output=True, text=True)
    if refused.returncode != 2 or "GODOBJECT_SIM" not in refused.stderr:
        sys.exit(f"--bus sim: {refused.returncode} {refused.stderr}")
    with simulated_rig(full, scene) as addresses:
        buses = [word for name, address in addresses.items() for word in ("--bus", f"{name}={address}")]
        run = subprocess.run([without, "run", scene, "--duration", "3", *buses], capture_output=True, text=True,
                             timeout=RUN_S)
    print(run.stdout + run.stderr)
    return run.returncode


if __name__ == "__main__":
    sys.exit(main())
