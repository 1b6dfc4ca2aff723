#!/usr/bin/env python3
"""Removes each mechanism and changes each number of core/tuning.h in turn, and counts the failures of the sweeps.

usage: ablate.py [--quick] [--only PATTERN] [--program NAME]... [--filter TESTS] [--share N] [--samples N]
                 [--instructions] [--report FILE]

Compiles the programs of programs.py once against a copy of core (switched_core.py), runs them as they are, then
once for each change. Results are in build/ablation/results, one file for each change and program; a run that was
interrupted is continued. Counts depend on the code alone. --quick: one change of each number instead of four, and
an eighth of each sweep.
"""
import argparse
import csv
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import programs
import switched_core
from mechanisms import MECHANISMS

SOURCE = pathlib.Path(__file__).resolve().parents[2]
OUT = SOURCE / "build/ablation"
PROGRAMS = ["map", *programs.TESTS]
# Changes of integers, and of numbers without a zero or an infinity.
VALUES = {
    "max_joint_iterations": [0, 2, 24], "substep_ratio": [16, 2], "max_substeps": [4, 64], "max_substeps_with_nets": [16, 256],
    "max_advances": [0, 10, 96], "max_newton_iterations": [5, 48],
    "max_line_steps": [0, 5, 48], "max_cg_iterations_searching": [1, 9],
    "max_cg_iterations": [2, 24], "node_strips": [1, 24], "nodes_looked_ahead": [1, 16], "net_iteration_divisor": [1, 6],
    "bridged_steps": [0, 1, 9], "max_scale": [1, 6], "FrictionAgainstTheWorld.by_tangent": [0, 12],
    "FrictionAgainstTheWorld.by_secant": [0, 6], "FrictionAmongBodies.by_tangent": [], "FrictionAmongBodies.by_secant": [0, 1, 15],
    "FrictionAgainstTheWorld.min_friction_change": [1e-3], "gain_window": [0.1, 10], "rigid_mass_ratio": [3e5, 3e6, 1e9],
    "same_normal": [0.9, 0.9999], "same_contact": [0, 0.9], "cell_radius_sq": [1, 3],
    "min_twist_share": [0, 0.75], "max_iterated_turn": [0.5, 1, 1e9],
}


def changes(name, value):
    """Values that replace a number: none, a third, three times, and unlimited."""
    if name in VALUES:
        return VALUES[name]
    return [0, float(value) / 3, 3 * float(value), 1e9]


def all_ablations(numbers, quick):
    """[(name in results, setting of GODOBJECT_ABLATION)]"""
    if unknown := VALUES.keys() - numbers.keys():
        sys.exit(f"ablate: VALUES has {', '.join(sorted(unknown))}, which core/tuning.h has not")
    ablations = [(name, name) for name, *_ in MECHANISMS]
    for name, value in numbers.items():
        values = changes(name, value)
        for new in values[:1] + values[-1:] if quick else values:
            ablations.append((f"{name} = {new:g}", f"{name}={new:.17g}"))
    return ablations


def run_tests(program, environment, seconds):
    """{test: passed} of a GoogleTest program; a test that ends the program, or its time, has not passed."""
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder) / "report.json"
        command = [OUT / program, f"--gtest_output=json:{report}", "--gtest_color=no"]
        try:
            run = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=seconds, cwd=SOURCE)
            text = run.stdout
        except subprocess.TimeoutExpired as expired:
            text = (expired.stdout or b"").decode(errors="replace")
    begun = re.findall(r"^\[ RUN      \] (\S+)", text, re.M)
    passed = set(re.findall(r"^\[       OK \] (\S+)", text, re.M))
    return {name: name in passed for name in begun}


def run_map(environment, seconds, samples):
    """{sample: its row without parameters} of the stability map, and whether it is sound."""
    with tempfile.TemporaryDirectory() as folder:
        rows = pathlib.Path(folder) / "map.csv"
        command = [OUT / "map", "--samples", str(samples), "--out", rows]
        try:
            subprocess.run(command, env=environment, capture_output=True, timeout=seconds, cwd=SOURCE)
        except subprocess.TimeoutExpired:
            pass
        lines = [line for line in rows.read_text().splitlines() if not line.startswith("#")] if rows.exists() else []
    results, sound, texts = list(csv.DictReader(lines)), {}, []
    for row in results:
        if None in row.values():
            continue
        name = f"{row['family']} {row['sample']} {row['integrator']}"
        is_sound = row["fault"] == "0" and row["reported"] == "0" and float(row["gain"]) <= 1e-3
        sound[name] = is_sound
        texts.append(",".join(row.values()))
    return sound, hashlib.sha256("\n".join(texts).encode()).hexdigest()[:16]


def path_of(name, kind):
    """File of the results of a change: of a program, or "instructions"."""
    return OUT / "results" / f"{re.sub(r'[^A-Za-z0-9.+-]+', '-', name)}.{kind}.json"


def stored(name, kind):
    path = path_of(name, kind)
    return json.loads(path.read_text()) if path.exists() else None


def result_of(program, setting, name, stamp, arguments):
    """The result of a program under a change, from its file if it was run before."""
    kept = stored(name, program)
    if kept and kept["stamp"] == stamp:
        return kept
    path = path_of(name, program)
    environment = dict(os.environ, GODOBJECT_ABLATION=setting)
    share = arguments.share or (8 if arguments.quick else 1)
    environment["GODOBJECT_SHARE"] = str(share)
    environment["GTEST_FILTER"] = arguments.filter
    if program == "map":
        cases, digest = run_map(environment, arguments.timeout, arguments.samples)
    else:
        cases, digest = run_tests(program, environment, arguments.timeout), ""
    selection = f"{arguments.samples} drawn" if program == "map" else f"`{arguments.filter}`, every case in {share}"
    result = {"stamp": stamp, "setting": setting, "selection": selection, "cases": cases, "digest": digest}
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_suffix(".part")
    partial.write_text(json.dumps(result))
    partial.rename(path)
    return result


def failures(base, changed):
    """Names of cases that are sound in the base and not under the change; a case that was not reached fails."""
    return [name for name, sound in base["cases"].items() if sound and not changed["cases"].get(name, False)]


def instructions_of(setting, name, stamp, samples=16):
    """Instructions of a short stability map under a change, by callgrind, from its file if counted before."""
    kept = stored(name, "instructions")
    if kept and kept["stamp"] == stamp:
        return kept["count"]
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", OUT / "map", "--samples",
                              str(samples), "--out", pathlib.Path(folder) / "map.csv"], capture_output=True, text=True,
                             env=dict(os.environ, GODOBJECT_ABLATION=setting), cwd=SOURCE)
    collected = re.search(r"Collected : (\d+)", run.stderr)
    count = int(collected.group(1)) if collected else None
    path_of(name, "instructions").write_text(json.dumps({"stamp": stamp, "count": count}))
    return count


def instructions_text(count, of):
    return f"{100 * (count / of - 1):+.1f} %" if count and of else ""


def reached(name):
    """Equation and file of a change."""
    for mechanism, equation, file, *_ in MECHANISMS:
        if mechanism == name:
            return f"{equation} `{file}`"
    return "`core/tuning.h`"


def write_table(path, numbers, quick):
    """Writes the table from all stored results: each change with its failures, and those that nothing missed."""
    bases = {program: stored("none", program) for program in PROGRAMS}
    bases = {program: base for program, base in bases.items() if base}
    rows, unmissed, not_run = [], [], []
    for name, _ in all_ablations(numbers, quick):
        results = {program: stored(name, program) for program in bases}
        results = {program: kept for program, kept in results.items() if kept and kept["stamp"] == bases[program]["stamp"]}
        lost = {program: len(failures(bases[program], kept)) for program, kept in results.items()}
        text = ", ".join(f"{program} {count}" for program, count in lost.items() if count)
        counted = [stored(change, "instructions") for change in (name, "none")]
        cost = instructions_text(*(one["count"] for one in counted)) if all(counted) else ""
        if text:
            rows.append(f"| {name} | {reached(name)} | {text} | {cost} |")
        else:
            (unmissed if results else not_run).append(f"{name} ({', '.join(results)})" if results else name)
    of = "; ".join(f"{program} {sum(base['cases'].values())} ({base['selection']})" for program, base in bases.items())
    lines = ["# What fails without each mechanism", "",
             "Written by `./dev ablate --report` from `build/ablation/results`. A row is core with one change. It counts "
             f"the cases that are sound in core and fail with the change, of: {of}.", "",
             "| without, or with | where | fails | instructions |", "|---|---|---|---|", *rows, "",
             "Not covered, because no case of the named programs fails: " + ("; ".join(unmissed) or "none") + ".", "",
             f"Not run: {len(not_run)} of {len(rows) + len(unmissed) + len(not_run)} changes."]
    path.write_text("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", default="", help="changes whose name matches this regular expression")
    parser.add_argument("--program", action="append", help="map, or a program of programs.py; all without it")
    parser.add_argument("--filter", default="*", help="tests, as of --gtest_filter")
    parser.add_argument("--share", type=int, help="run every so many cases of a sweep (tests/support/share.h)")
    parser.add_argument("--samples", type=int, default=800, help="of the stability map")
    parser.add_argument("--timeout", type=float, default=3600, help="of a program, s")
    parser.add_argument("--instructions", action="store_true", help="count those of a short stability map, by callgrind")
    parser.add_argument("--report", type=pathlib.Path, help="file whose table to write")
    arguments = parser.parse_args()
    numbers = switched_core.copy(SOURCE, OUT)
    programs.write_build(SOURCE, OUT)
    chosen = arguments.program or PROGRAMS
    subprocess.run(["ninja", "-f", OUT / "build.ninja", *(f"build/ablation/{name}" for name in chosen)], cwd=SOURCE,
                   check=True)
    stamps = {name: hashlib.sha256((OUT / name).read_bytes() +
                                   f"{arguments.quick} {arguments.share} {arguments.filter} {arguments.samples}".encode()).hexdigest()[:16]
              for name in chosen}
    base = {name: result_of(name, "", "none", stamps[name], arguments) for name in chosen}
    for name in chosen:
        cases = base[name]["cases"]
        print(f"ablate: {name}: {sum(cases.values())} of {len(cases)} cases sound", flush=True)
    for name, setting in all_ablations(numbers, arguments.quick):
        if not re.search(arguments.only, name):
            continue
        failed = {}
        for program in chosen:
            changed = result_of(program, setting, name, stamps[program], arguments)
            lost = failures(base[program], changed)
            failed[program] = (len(lost), bool(changed["digest"]) and changed["digest"] == base[program]["digest"])
        instructions = ""
        if arguments.instructions and "map" in chosen:
            count, of = (instructions_of(*change, stamps["map"]) for change in ((setting, name), ("", "none")))
            instructions = instructions_text(count, of)
        text = ", ".join(f"{program} {lost}{' (same rows)' if same else ''}"
                         for program, (lost, same) in failed.items() if lost or same)
        print(f"ablate: {name}: {text or 'nothing'} {instructions}", flush=True)
    if arguments.report:
        write_table(arguments.report, numbers, arguments.quick)
    return 0


if __name__ == "__main__":
    sys.exit(main())
