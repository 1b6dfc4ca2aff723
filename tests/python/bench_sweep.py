#!/usr/bin/env python3
"""Times sweeps of short runs from Python and from C++ (bench_sweep.cc), and prints the speed of Python in percent of C++.

    ./dev build release godobject_sweep python_module
    /usr/bin/python3 tests/python/bench_sweep.py [SCENE [RUNS [STEPS]]]

parsed: one scene, started again for each run. parsed_each: for each run a scene of dicts, with another mass of its first
body; in C++ its text is parsed. Both take processor time for parts of RUNS_A_PART runs in turns, each first in every
other pair, so that other load slows both. Prints the median of the pairs' ratios, and their quartiles. The states of
the first are compared. Exits with 1 below 95 %.
"""
import os
import statistics
import subprocess
import sys
import time
import tomllib
import warnings
from pathlib import Path

sys.path[:0] = ["platform/python", "build/release/platform/python"]
from godobject import Scene, SceneWarning

RUNS_A_PART = 10
REQUIRED = 95  # percent


class Python:
    """Sweeps in this process."""

    def __init__(self, path, steps):
        warnings.simplefilter("ignore", SceneWarning)
        with open(path, "rb") as file:
            self.parts = tomllib.load(file)
        self.mass, self.scene, self.folder, self.steps = self.parts["body"][0]["mass"], Scene(path), Path(path).parent, steps

    def part(self, kind, first, runs):
        """Returns the processor time in s, and the hash of the state after sweeps of the same scene."""
        start = time.process_time()
        if kind == "parsed":
            for _ in range(runs):
                self.scene.reset()
                self.scene.step(self.steps)
        else:
            for i in range(first, first + runs):
                self.parts["body"][0]["mass"] = self.mass * (1 + 1e-4 * i)
                Scene.from_dict(self.parts, folder=self.folder).step(self.steps)
        return time.process_time() - start, self.scene.state_hash


class Cpp:
    """Sweeps in a process of its own."""

    def __init__(self, path, steps):
        self.process = subprocess.Popen(["build/release/tests/python/godobject_sweep", path, str(steps)], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, text=True)

    def part(self, kind, first, runs):
        self.process.stdin.write(f"{kind} {first} {runs}\n")
        self.process.stdin.flush()
        seconds, state_hash = self.process.stdout.readline().split()
        return float(seconds), state_hash


def main(path="sim/scenes/wall.toml", runs="1000", steps="1000"):
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # both on one processor
    python, cpp = Python(path, int(steps)), Cpp(path, int(steps))
    is_fast = True
    for kind in ("parsed", "parsed_each"):
        for one in (python, cpp):
            one.part(kind, 0, 2)  # warm
        pairs = []
        for first in range(0, int(runs), RUNS_A_PART):
            sides = (cpp, python) if first // RUNS_A_PART % 2 else (python, cpp)
            taken = {side: side.part(kind, first, min(RUNS_A_PART, int(runs) - first)) for side in sides}
            if kind == "parsed" and taken[python][1] != taken[cpp][1]:
                sys.exit("the states differ")
            pairs.append((taken[cpp][0], taken[python][0]))
        low, median, high = statistics.quantiles([100 * c / p for c, p in pairs], n=4)
        c, p = (sum(seconds) for seconds in zip(*pairs))
        print(f"{path}, {runs} runs of {steps} steps, {kind}: C++ {c:.3f} s, Python {p:.3f} s, median {median:.1f} % "
              f"({low:.1f} to {high:.1f})")
        is_fast = is_fast and median >= REQUIRED
    cpp.process.stdin.close()
    cpp.process.wait()
    return 0 if is_fast else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
