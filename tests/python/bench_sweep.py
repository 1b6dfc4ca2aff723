#!/usr/bin/env python3
"""Times sweeps of short runs from Python and from C++ (bench_sweep.cc), and prints the speed of Python in percent of C++.

    ./dev build release godobject_sweep python_module
    /usr/bin/python3 tests/python/bench_sweep.py [SCENE [RUNS [STEPS]]]

parsed: one scene, started again for each run. parsed_each: for each run a scene of dicts, with another mass of its first
body; in C++ its text is parsed. Processor time, best of five taken in turns. The states of the first are compared.
"""
import subprocess
import sys
import time
import tomllib
import warnings
from pathlib import Path

sys.path.insert(0, "platform/python")
from godobject import Scene, SceneWarning

TURNS = 5


def sweep(path, runs, steps):
    """Seconds of processor time of each sweep."""
    warnings.simplefilter("ignore", SceneWarning)
    with open(path, "rb") as file:
        parts = tomllib.load(file)
    mass, seconds = parts["body"][0]["mass"], {}
    scene = Scene(path)
    start = time.process_time()
    for _ in range(runs):
        scene.reset()
        scene.step(steps)
    seconds["parsed"] = time.process_time() - start
    start = time.process_time()
    for i in range(runs):
        parts["body"][0]["mass"] = mass * (1 + 1e-4 * i)
        Scene.from_dict(parts, folder=Path(path).parent).step(steps)
    seconds["parsed_each"] = time.process_time() - start
    return seconds, scene.state_hash


def main(path="sim/scenes/wall.toml", runs="1000", steps="1000"):
    best = {}
    for _ in range(TURNS):
        printed = subprocess.run(["build/release/tests/python/godobject_sweep", path, runs, steps], capture_output=True,
                                 text=True, check=True).stdout
        cpp = {name: (float(s), hashed) for name, s, hashed in map(str.split, printed.splitlines())}
        python, state_hash = sweep(path, int(runs), int(steps))
        if cpp["parsed"][1] != state_hash:
            sys.exit("the states differ")
        for name in python:
            c, p = best.get(name, (float("inf"), float("inf")))
            best[name] = min(c, cpp[name][0]), min(p, python[name])
    for name, (c, p) in best.items():
        print(f"{path}, {runs} runs of {steps} steps, {name}: C++ {c:.3f} s, Python {p:.3f} s, {100 * c / p:.1f} %")


if __name__ == "__main__":
    main(*sys.argv[1:])
