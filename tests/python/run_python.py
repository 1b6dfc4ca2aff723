"""Runs the tests of the Python module with pytest; exits with 77 and the reason if they cannot run.

usage: run_python.py --program GODOBJECT --module FOLDER [--left-out WHY] [PYTEST OPTION...]

FOLDER: platform/python of the build directory. WHY: reason why the build has no module; empty if it has one.
"""
import argparse
import importlib.util
import os
import sys
from pathlib import Path

PACKAGES = {"numpy": "python3-numpy", "pytest": "python3-pytest"}
SOURCE = Path(__file__).resolve().parents[2]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    parser.add_argument("--module", required=True)
    parser.add_argument("--left-out", default="")
    known, further = parser.parse_known_args()
    if known.left_out:
        print(f"skipped: the build has no Python module: {known.left_out}")
        return 77
    missing = [debian for module, debian in PACKAGES.items() if importlib.util.find_spec(module) is None]
    if missing:
        print(f"skipped: {sys.executable} has no {', '.join(missing)}: apt-get install {' '.join(missing)}")
        return 77
    import pytest
    sys.dont_write_bytecode = True
    os.chdir(SOURCE)
    os.environ["GODOBJECT_PROGRAM"] = known.program
    sys.path[:0] = [str(SOURCE / "platform/python"), known.module]
    os.environ["PYTHONPATH"] = os.pathsep.join(sys.path[:2])
    return pytest.main(["-q", "-p", "no:cacheprovider", str(Path(__file__).parent), *further])


if __name__ == "__main__":
    sys.exit(main())
