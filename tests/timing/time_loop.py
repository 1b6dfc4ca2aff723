#!/usr/bin/env python3
"""Measures the real-time loop on this machine, and writes the result into a page.

usage: time_loop.py budget|wake-up GODOBJECT [--page PAGE] [--seconds S] [--rounds N] [--bound RATIO]

budget   times of a cycle's stages on the grasper: its device simulated by a second program, on pseudo-terminals,
         and for comparison within the loop
wake-up  wake-ups of the loop and of cyclictest (Debian's rt-tests) in turn, same priority, policy and period;
         fails if the median of the ratios of their 99.9th percentiles is above --bound

Without --page it only prints. Exit code 77, with the reason, where it cannot measure.
"""

import argparse
import json
import os
import pathlib
import platform
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

GRASPER, STEADY = "sim/scenes/grasper.toml", "sim/scenes/rigid.toml"
PRIORITY, PERIOD_US = 80, 1000
LONGEST_US = 100_000  # of cyclictest's histogram


def skip(why):
    print(f"time_loop: skipped: {why}", file=sys.stderr)
    sys.exit(77)


def machine():
    cpu = re.search(r"^model name\s*: (.*)$", pathlib.Path("/proc/cpuinfo").read_text(), re.M)
    load = float(pathlib.Path("/proc/loadavg").read_text().split()[0])
    busy = f"busy (load {load:.0f}): no verdict" if load > os.cpu_count() else f"load {load:.1f}"
    return (f"{cpu.group(1) if cpu else platform.machine()}, Linux {platform.release()}"
            f"{', PREEMPT_RT' if 'PREEMPT_RT' in platform.version() else ', no PREEMPT_RT'}, {busy}")


def run(program, *arguments):
    """Report of a run of the program."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "report.json"
        subprocess.run([program, "run", *arguments, "--quiet", "--report", path], check=False, stdin=subprocess.DEVNULL)
        return json.loads(path.read_text())


def on_terminals(program, seconds):
    """Report of a run against `simulate` in a second program."""
    with subprocess.Popen([program, "simulate", GRASPER, "--realtime", "--control", "-", "--bus", "pty"],
                          stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as far:
        buses = []
        for line in far.stdout:
            if line.strip() == "ready":
                break
            name, terminal = re.match(r"bus (\S+): (\S+)", line).groups()
            buses += ["--bus", f"{name}=slcan:{terminal}"]
        report = run(program, GRASPER, *buses, "--duration", str(seconds))
        far.stdin.close()
        far.terminate()
    return report


def budget(options):
    apart, within = on_terminals(options.godobject, options.seconds), run(options.godobject, GRASPER, "--realtime",
                                                                          "--duration", str(options.seconds))
    rows = ["| us | p50 | p99.9 | max |", "|---|---|---|---|"]
    timing, other = apart["timing"], within["timing"]["compute_us"]
    for name, us in [*timing["stages_us"].items(), ("compute", timing["compute_us"])]:
        rows.append(f"| {name} | {us['p50']:.1f} | {us['p99_9']:.1f} | {us['max']:.1f} |")
    about = (f"{timing['missed_deadlines']} of {apart['cycles']} deadlines missed. Device within the loop: compute p50 "
             f"{other['p50']:.1f}, p99.9 {other['p99_9']:.1f} us. {time.strftime('%Y-%m-%d')}; {machine()}")
    return rows, about, True


def cyclictest(seconds):
    """The 99.9th percentile and the maximum of cyclictest's wake-ups, us."""
    output = subprocess.run(["cyclictest", "-q", "-m", "-t1", f"-p{PRIORITY}", f"-i{PERIOD_US}", f"-D{seconds}",
                             f"-h{LONGEST_US}"], check=False, capture_output=True, text=True)
    if output.returncode != 0:
        skip(f"cyclictest: {output.stderr.strip()}")
    bins = [(int(us), int(count)) for us, count in re.findall(r"^(\d+)\s+(\d+)$", output.stdout, re.M)]
    total, seen = sum(count for _, count in bins), 0
    for us, count in bins:
        seen += count
        if seen >= 0.999 * total:
            break
    longest = re.search(r"^# Max Latencies: (\d+)", output.stdout, re.M)
    return us, int(longest.group(1))


def wake_up(options):
    if not shutil.which("cyclictest"):
        skip("no cyclictest: apt install rt-tests")
    ours, theirs, ratios = [], [], []
    for number in range(1, options.rounds + 1):
        report = run(options.godobject, STEADY, "--bus", "direct", "--realtime", "--duration", str(options.seconds))
        setup = {step["step"]: step for step in report["machine"]["rt_setup"]}
        if setup["priority"]["result"] != "ok":
            skip(f"priority: {setup['priority']['detail']}")
        wake = report["timing"]["wake_us"]
        p99_9, longest = cyclictest(options.seconds)
        ours.append(f"{wake['p99_9']:.0f}")
        theirs.append(f"{p99_9}")
        ratios.append(wake["p99_9"] / max(p99_9, 1))
        print(f"round {number}: loop {ours[-1]}, at most {wake['max']:.0f}; cyclictest {p99_9}, at most {longest} us", flush=True)
    median = statistics.median(ratios)
    rows = [f"p99.9 of {options.rounds} rounds, us: loop {', '.join(ours)}; cyclictest {', '.join(theirs)}; "
            f"median ratio {median:.2f}"]
    about = f"{options.seconds} s each, SCHED_FIFO {PRIORITY}; {time.strftime('%Y-%m-%d')}; {machine()}"
    return rows, about, options.bound is None or median <= options.bound


def write(page, name, text):
    """Replaces the text between the two lines that name the measurement."""
    begin, end = f"<!-- {name}: begin -->\n", f"<!-- {name}: end -->\n"
    before = page.read_text()
    if begin not in before or end not in before:
        sys.exit(f"{page}: has no lines {begin}and {end}between which the result belongs")
    page.write_text(before[: before.index(begin) + len(begin)] + text + before[before.index(end):])


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("measurement", choices=["budget", "wake-up"])
    parser.add_argument("godobject")
    parser.add_argument("--page", type=pathlib.Path)
    parser.add_argument("--seconds", type=int, default=10)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--bound", type=float)
    options = parser.parse_args()
    rows, about, good = {"budget": budget, "wake-up": wake_up}[options.measurement](options)
    text = "\n".join(rows) + f"\n\n{about}\n"
    print(text)
    if options.page:
        write(options.page, options.measurement, text)
    if not good:
        sys.exit(f"time_loop: the median of the ratios is above {options.bound}")


if __name__ == "__main__":
    main()
