#!/usr/bin/env python3
"""Runs a scene with the program that has no simulated devices, on a rig that the full program simulates.

usage: without_sim.py GODOBJECT WITHOUT_SIM SCENE NM LIBGODOBJECT_SIM
"""
import re
import subprocess
import sys

RUN_S = 60


def symbols(nm, path):
    listing = subprocess.run([nm, "--defined-only", "--extern-only", path], check=True, capture_output=True, text=True)
    return {line.split()[2] for line in listing.stdout.splitlines() if len(line.split()) == 3}


def own(nm, library):
    """Of the simulation itself: strong functions, which no other library of the project defines as well."""
    listing = subprocess.run([nm, "--defined-only", "--extern-only", library], check=True, capture_output=True, text=True)
    return {fields[2] for fields in map(str.split, listing.stdout.splitlines()) if len(fields) == 3 and fields[1] == "T"}


def main():
    full, without, scene, nm, library = sys.argv[1:]
    of_sim = own(nm, library)
    if not of_sim & symbols(nm, full):
        sys.exit("the full program has no symbol of the simulation: this says nothing")
    left = of_sim & symbols(nm, without)
    if left:
        sys.exit(f"{len(left)} symbols of the simulation: {sorted(left)[:5]}")
    refused = subprocess.run([without, "run", scene, "--fast"], capture_output=True, text=True)
    if refused.returncode != 2 or "GODOBJECT_SIM" not in refused.stderr:
        sys.exit(f"--bus sim: {refused.returncode} {refused.stderr}")
    with subprocess.Popen([full, "simulate", scene, "--bus", "pty", "--realtime", "--duration", "60"],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as simulated:
        try:
            addresses = {}
            for line in simulated.stdout:
                addresses.update(re.findall(r"bus (\w+): (/dev/pts/\d+)", line))
                if line.strip() == "ready":
                    break
            buses = [word for name, path in addresses.items() for word in ("--bus", f"{name}=slcan:{path}")]
            run = subprocess.run([without, "run", scene, "--duration", "3", *buses], capture_output=True, text=True,
                                 timeout=RUN_S)
        finally:
            simulated.terminate()
            simulated.wait(timeout=RUN_S)
    print(run.stdout + run.stderr)
    return run.returncode


if __name__ == "__main__":
    sys.exit(main())
