#!/usr/bin/env python3
"""Runs the example `program`: its hand, its law and its mesh are in trace, record, report and view, and its hand is
supervised.

usage: own_program.py EXAMPLE FOLDER_OF_ITS_SOURCE WORK
"""
import csv
import json
import subprocess
import sys
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent.parent / "view"))
from viewed_run import ViewedRun  # noqa: E402

RUNNING, RUNNING_DOWN = 2, 3


def run(*command):
    result = subprocess.run(list(map(str, command)), text=True, capture_output=True, timeout=120)
    print(result.stdout + result.stderr)
    assert result.returncode == 0, (command, result.returncode)
    return result.stdout + result.stderr


def check_files(example, scene, work):
    trace, record, report = work / "t.csv", work / "r.godo", work / "r.json"
    output = run(example, "run", scene, "--fast", "--trace", trace, "--record", record, "--report", report)
    assert "the device is that of this program" in output, output
    with open(trace, newline="", encoding="utf-8") as file:
        rows = [{name: float(value) for name, value in row.items() if value} for row in csv.DictReader(file)]
    end = rows[-1]
    assert len(rows) == 4001 and abs(end["peg.target.z"] - 0.03) < 1e-9, "the hand has gone down by 50 mm"
    assert end["peg.z"] > end["peg.target.z"] + 0.004, ("the mesh holds the peg", end["peg.z"])
    assert end["peg.contact.fz"] > 1, "N"
    assert json.loads(report.read_text(encoding="utf-8"))["cycles"] == 4000
    run(example, "replay", record)
    run(example, "run", scene, "--fast", "--quiet", "--bus", "direct", "--trace", work / "direct.csv")
    with open(work / "direct.csv", newline="", encoding="utf-8") as file:
        *_, last = csv.DictReader(file)
    assert float(last["peg.target.z"]) == 0.08, "without its hand"


def check_view(example, scene, work):
    with ViewedRun(example, "run", str(scene), "--view", "--quiet", folder=str(work)) as viewed:
        stream = viewed.stream()
        about = stream.scene()
        roof = [solid for solid in about["solids"] if solid["kind"] == "mesh" and solid["role"] == "obstacle"]
        assert len(roof) == 1, about["solids"]
        while stream.frame()["targets"][0][2] > 0.04:
            pass  # the hand goes down
        viewed.process.send_signal(2)
        phases = set()
        try:
            while True:
                phases.add(stream.frame()["phase"])
        except (ConnectionError, OSError):
            pass
        assert RUNNING_DOWN in phases, (phases, viewed.text())


def main():
    example, source, work = map(Path, sys.argv[1:])
    work.mkdir(exist_ok=True)
    check_files(example, source / "scene.toml", work)
    check_view(example, source / "scene.toml", work)


if __name__ == "__main__":
    main()
