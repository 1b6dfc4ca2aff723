#!/usr/bin/env python3
"""Runs a scene with the program that has no simulated devices, on a rig that the full program simulates.

usage: without_sim.py GODOBJECT LIBGODOBJECT_SIM WITHOUT_SIM SCENE NM
"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from simulated_rig import exit_code_unless_starved, simulated_rig
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
    return exit_code_unless_starved(lambda: run(full, without, scene))


def run(full, without, scene):
    with simulated_rig(full, scene) as addresses, tempfile.TemporaryDirectory() as folder:
        buses = [word for name, address in addresses.items() for word in ("--bus", f"{name}={address}")]
        report = Path(folder) / "report.json"
        result = subprocess.run([without, "run", scene, "--duration", "3", "--report", report, *buses], capture_output=True,
                                text=True, timeout=RUN_S)
        print(result.stdout + result.stderr)
        seen = json.loads(report.read_text()) if report.exists() else None
        return result.returncode, result.returncode == 1 and was_starved(seen)


def was_starved(report):
    """True if the run has made cycles and was held: the machine left it, or the simulator, without a processor."""
    return (report is not None and report["cycles"] > 0 and
            bool({"held", "deadlines_missed"} & {fault["name"] for fault in report["faults"]}))


if __name__ == "__main__":
    sys.exit(main())
