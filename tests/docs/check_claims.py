#!/usr/bin/env python3
"""Each claim of docs/theory/paper.md has a verdict, and tests and scenes that exist.

usage: check_claims.py SOURCE_DIR
"""
import pathlib
import re
import sys

from verdict import verdict

PAGE = "docs/theory/paper.md"
TEST = re.compile(r"^TEST(?:_F|_P)?\((\w+),\s*(\w+)\)|^TYPED_TEST\((\w+),\s*(\w+)\)", re.M)
ROW = re.compile(r"^\| (?!-|equation|claim)(.*) \|$", re.M)
NAME = re.compile(r"`([A-Z]\w+)`")  # part of the name of a test
FILE = re.compile(r"`[^`]*?((?:sim|tests)/[\w./-]+\.(?:toml|csv))[^`]*`")
VERDICTS = ("confirmed", "bounded", "overcome")


def complaints(page, tests, exists):
    """Returns the faults of a page and the number of its claims. exists: function of a path."""
    found, rows = [], ROW.findall(page)
    for row in rows:
        claim, verdict_of, *_ = row.split(" | ")
        if not verdict_of.startswith(VERDICTS) and not re.match(r"[\d.]+ us", verdict_of):
            found.append(f"{PAGE}: no verdict for '{claim}': begin it with one of {', '.join(VERDICTS)}")
        names = NAME.findall(row)
        if not names and "godobject" not in row:
            found.append(f"{PAGE}: neither test nor command for '{claim}'")
        found += [f"{PAGE}: no test is called '{name}'" for name in names if not any(name in test for test in tests)]
        found += [f"{PAGE}: {file} does not exist" for file in FILE.findall(row) if "NAME" not in file and not exists(file)]
    return found, len(rows)


def finds_a_broken_one():
    page = ("| claim | verdict | shown |\n|---|---|---|\n| a | confirmed | `Suite` |\n| b | perhaps | `NoSuite`, `run tests/no.csv` |\n"
            "| c | bounded | - |\n")
    found, rows = complaints(page, {"Suite.Works"}, lambda path: False)
    return rows == 3 and len(found) == 4


def main(source):
    tests = {f"{a or c}.{b or d}" for path in (source / "tests").rglob("*.cc") for a, b, c, d in TEST.findall(path.read_text())}
    found, claims = complaints((source / PAGE).read_text(), tests, lambda path: (source / path).exists())
    return verdict("check_claims.py", finds_a_broken_one(), found, claims, f"{claims} claims of the paper, each with tests that exist")


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
