#!/usr/bin/env python3
"""No comment begins with "Of": what it is about stands first, then what that is of.

"/// Of a contact." above a function says whose, not what: "/// Effective mass of a contact." says both.

usage: check_comments.py SOURCE_DIR
"""
import pathlib
import re
import sys
import tempfile

ROOMS = ("core", "hal", "sim", "platform")
SOURCES = {".h", ".cc", ".js"}
BARE = re.compile(r"^\s*///? Of ")


def bare_comments(source):
    """(number of files read, places of comments that begin with "Of")."""
    read, bare = 0, []
    for room in ROOMS:
        for path in sorted((source / room).rglob("*")):
            if path.suffix not in SOURCES:
                continue
            read += 1
            for number, line in enumerate(path.read_text().splitlines(), 1):
                if BARE.match(line):
                    bare.append(f"{path.relative_to(source)}:{number}: {line.strip()}")
    return read, bare


def finds_a_bare_one():
    """The check itself: of these comments the two that begin with "Of" are told."""
    with tempfile.TemporaryDirectory() as made:
        source = pathlib.Path(made)
        (source / "core").mkdir()
        (source / "core/a.h").write_text(
            "/// Of a contact.\n/// Mass of a contact.\nint m;  // Of it\n  // Of two.\n// Often.\n")
        return bare_comments(source) == (1, ["core/a.h:1: /// Of a contact.", "core/a.h:4: // Of two."])


def main(source):
    if not finds_a_bare_one():
        print("check_comments.py does not find the bare comments of its own example")
        return 1
    read, bare = bare_comments(source)
    print("\n".join(f"{place}  -- what of it?" for place in bare) or f"{read} files, no comment begins with Of")
    return 1 if bare or not read else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
