#!/usr/bin/env python3
"""Writes the result of one sanitizer run into its row of the report.

usage: report_sanitizers.py REPORT PRESET MEANING RESULT DATE COMMIT

The rows stand between two lines of the report, which a new study keeps.
"""
import pathlib
import re
import sys

BEGIN, END = "<!-- begin of the sanitizers -->\n", "<!-- end of the sanitizers -->\n"
HEAD = """## Sanitizers

Last runs: asan-all, tsan-all, rtsan by `./dev sanitize`, over every test; the others, with fewer, by `./dev test --all`.

| preset | what it checks | result | date | commit |
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
