#!/usr/bin/env python3
"""Measures the times of test_torque_gone.py and writes them into the table of docs/faults.md.

usage: write_torque_gone.py --program build/release/platform/godobject --looping build/release/tests/hil/godobject_looping
Each time is the longest of REPEATS measurements. moteus is measured in a guest, because SLCAN carries no CAN FD.
"""
import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "platform/python"))
import test_torque_gone  # noqa: E402

PAGE = SOURCE / "docs/faults.md"
BEGIN, END = "<!-- torque gone: begin -->\n", "<!-- torque gone: end -->\n"
REPEATS = 3
# Watchdogs as the makers deliver their drives.
# moteus: fw/bldc_servo_structs.h, default_timeout_s = 0.1, timeout_mode = 12 (github.com/mjbots/moteus).
# ODrive: Firmware/MotorControl/axis.hpp, enable_watchdog = false (github.com/odriverobotics/ODrive).
# CiA 301: 1016h and xx:05 of RPDOs are 0, which is off.
ROWS = {("generic-402",): "off", ("epos4", "nanotec"): "off", ("odrive",): "off", ("moteus",): "100"}


def measure(arguments, folder):
    """Returns the times, ms, by (drive, way)."""
    found = {}
    guest = [SOURCE / "tests/vm/run_in_guest", "--engine", "uml", SOURCE / "tests/vm/can_interfaces"]
    for repeat in range(REPEATS):
        for tier, start, chosen in (("pty", [], "torque_gone"), ("vcan", guest, "torque_gone and moteus")):
            file = folder / f"{tier}{repeat}"
            command = [*start, sys.executable, SOURCE / "tests/hil/run_hil.py", "--program", arguments.program.resolve(),
                       "--looping", arguments.looping.resolve(), "--tier", tier, "-k", chosen, "--torque-gone", file]
            if subprocess.run(list(map(str, command)), cwd=folder).returncode != 0:
                sys.exit("write_torque_gone: a time is too long, see above; the table is as before")
            for line in file.read_text().splitlines():
                one = json.loads(line)
                found.setdefault((one["drive"], one["way"]), []).append(one["ms"])
    return found


def table(found):
    lines = [f"| drive | {' | '.join(test_torque_gone.WAYS)} | maker's |", "|---" * (len(test_torque_gone.WAYS) + 2) + "|"]
    for drives, maker in ROWS.items():
        times = [f"{max(ms for drive in drives for ms in found[drive, way]):.1f}" for way in test_torque_gone.WAYS]
        lines.append(f"| {', '.join(drives)} | {' | '.join(times)} | {maker} |")
    return "".join(line + "\n" for line in lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, required=True)
    parser.add_argument("--looping", type=Path, required=True)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = measure(arguments, Path(folder))
    before, rest = PAGE.read_text().split(BEGIN)
    PAGE.write_text(before + BEGIN + table(found) + END + rest.split(END)[1])


if __name__ == "__main__":
    main()
