#!/usr/bin/env python3
"""Writes the result of one long check, of sanitizers or mutants, into its row of the report.

usage: long_check.py REPORT CHECK MEANING RESULT DATE COMMIT

The rows stand between two lines of the report, which a new study keeps.
"""
import pathlib
import re
import sys

from sections import split


HEAD = """## Sanitizers and mutants

Last runs: asan-all, tsan-all, rtsan by `./dev sanitize`, over every test; mutants by `./dev mutate`, survivors in
`tests/mutation/survivors.txt`; endure by `./dev endure`; aarch64 by `./dev test-aarch64`; the others, with fewer tests, by
`./dev test --all`.

| check | of | result | date | commit |
|---|---|---|---|---|
"""


def main():
    path, *cells = sys.argv[1:]
    before, section, after = split(path, "long checks")
    rows = {row.split(" | ")[0]: row for row in re.findall(r"^\| .* \| \d{4}-\d\d-\d\d \| .*$", section, re.M)}
    rows[f"| {cells[0]}"] = f"| {' | '.join(cells)} |"
    pathlib.Path(path).write_text(before + HEAD + "".join(f"{rows[name]}\n" for name in sorted(rows)) + "\n" + after)


if __name__ == "__main__":
    main()
