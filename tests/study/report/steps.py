#!/usr/bin/env python3
"""Writes the report's section of steps that the benchmarks alone time, from their results.

usage: steps.py BENCH.json REPORT

BENCH.json: of ./dev bench.
"""
import json
import pathlib
import re
import sys

from head import ENGINES, OURS
from sections import split

# Name of a row, its benchmarks of the core without the integrator, those of the other engines.
STEPS = (("rigid tool with feedback, S1", "S1/haptic-1", None), ("64 links on ball joints, S5", "S5/free-joints-64", "S5/64"))
HEAD = """## Steps of the benchmarks

Steps that the sections above do not time. Medians of `./dev bench --page`, us; other engines with their fastest setting:

"""


def medians(results):
    """Returns the median time of a step, us, of each benchmark."""
    return {re.sub("/(min_time|iterations|repeats):.*", "", b["run_name"]): b["p50_ns"] / 1000
            for b in results["benchmarks"] if b.get("aggregate_name") == "median"}


def cells_of(times, ours, others, path):
    for integrator in OURS:
        name = f"{ours} {integrator}"
        if name not in times:
            sys.exit(f"{path}: has no '{name}': run ./dev bench --page without a filter")
        yield f"{times[name]:.2g}"
    for engine in ENGINES:
        found = [time for name, time in times.items() if others and name.startswith(f"{others}/{engine}")]
        yield f"{min(found):.3g}" if found else "-"


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    path, report = sys.argv[1:]
    times = medians(json.loads(pathlib.Path(path).read_text()))
    columns = ("step", *OURS, *ENGINES)
    rows = [columns, ["---"] * len(columns)] + [(name, *cells_of(times, ours, others, path)) for name, ours, others in STEPS]
    before, _, after = split(report, "steps")
    lines = "".join(f"| {' | '.join(row)} |\n" for row in rows).replace("| --- |", "|---|").replace(" --- |", "---|")
    pathlib.Path(report).write_text(f"{before}{HEAD}{lines}\n{after}")


if __name__ == "__main__":
    main()
