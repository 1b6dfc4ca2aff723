#!/usr/bin/env python3
"""Writes the result of one long check, of sanitizers or mutants, into its row of the report.

usage: report_long_check.py REPORT CHECK MEANING RESULT DATE COMMIT

The rows stand between two lines of the report, which a new study keeps.
"""
import pathlib
import re
import sys

BEGIN, END = "<!-- begin of the long checks -->\n", "<!-- end of the long checks -->\n"
HEAD = """## Sanitizers and mutants

Last runs: asan-all, tsan-all, rtsan by `./dev sanitize`, over every test; mutants by `./dev mutate`, survivors in
`tests/mutation/survivors.txt`; endure by `./dev endure`; aarch64 by `./dev test-aarch64`; the others, with fewer tests, by
`./dev test --all`.

| check | of | result | date | commit |
|---|---|---|---|---|
"""


def main():
    path, *cells = sys.argv[1:]
    report = pathlib.Path(path)
    text = report.read_text()
    if BEGIN not in text or END not in text:
        sys.exit(f"{path}: has no lines {BEGIN}and {END}between which the results belong: write the report with ./dev study first")
    begin, end = text.index(BEGIN) + len(BEGIN), text.index(END)
    rows = {row.split(" | ")[0]: row for row in re.findall(r"^\| .* \| \d{4}-\d\d-\d\d \| .*$", text[begin:end], re.M)}
    rows[f"| {cells[0]}"] = f"| {' | '.join(cells)} |"
    report.write_text(text[:begin] + HEAD + "".join(f"{rows[name]}\n" for name in sorted(rows)) + "\n" + text[end:])


if __name__ == "__main__":
    main()
