#!/usr/bin/env python3
"""Prints a histogram of report.json for gnuplot: one line per bin, upper edge (us) and count.

usage: histogram.py report.json wake_us|compute_us
Exits with 1 and an error message if the report has no such histogram.
"""

import json
import sys


def main() -> int:
    path, name = sys.argv[1:]
    try:
        with open(path, encoding="utf-8") as file:
            bins = json.load(file)["timing"][name]["histogram"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        print(f"{path}: no timing.{name}.histogram ({error!r})", file=sys.stderr)
        return 1
    for upper_us, count in bins:
        print(upper_us, count)
    return 0


if __name__ == "__main__":
    sys.exit(main())
