#!/usr/bin/env python3
"""Checks that a product on hardware links no simulation: neither the program, which links godobject::platform alone, nor what the
installed libraries below it need.

usage: links_no_simulation.py NM PREFIX PROGRAM
"""
import pathlib
import sys

from symbols import functions_of, symbols


def main():
    nm, prefix, program = sys.argv[1:]
    library = {path.name: path for path in pathlib.Path(prefix).rglob("libgodobject_*.a")}
    simulation = functions_of(nm, library["libgodobject_sim.a"], library["libgodobject_simulated.a"])
    if not simulation & symbols(nm, f"{prefix}/bin/godobject", "T", "--defined-only"):
        sys.exit("the full program has no symbol of the simulation: this says nothing")
    if not symbols(nm, library["libgodobject_platform.a"], "U"):
        sys.exit("the library needs nothing at all: this says nothing")
    found = {program: simulation & symbols(nm, program, "TW", "--defined-only")}
    for name in ("libgodobject_hal.a", "libgodobject_platform.a"):
        found[name] = simulation & symbols(nm, library[name], "TU")
    for name, left in found.items():
        print(f"{name}: {len(left)} of {len(simulation)} symbols of the simulation {sorted(left)[:5]}")
    return 1 if any(found.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
