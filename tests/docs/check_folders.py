#!/usr/bin/env python3
"""Each folder of core, hal, sim and platform has a line in docs/architecture.md; each line there has its folder and file.

usage: check_folders.py SOURCE_DIR
"""
import pathlib
import re
import sys

from verdict import verdict

PAGE = "docs/architecture.md"
LAYERS = ("core", "hal", "sim", "platform")
NOT_CONTENTS = {"CMakeLists.txt"}
LINE = re.compile(r"^- `((?:core|hal|sim|platform)[\w/]*)` \(`([\w./-]+)`\): (\S.*)$", re.M)


def folders_of(source):
    """Folders of the layers with files other than build descriptions."""
    return {str(path.parent.relative_to(source)) for layer in LAYERS for path in (source / layer).rglob("*")
            if path.is_file() and path.name not in NOT_CONTENTS and "__pycache__" not in path.parts}


def complaints(page, folders, exists):
    """Folders without a line, and lines whose folder or file does not exist. exists: function of a path."""
    lines = {folder: first for folder, first, _ in LINE.findall(page)}
    return ([f"{PAGE}: no line for the folder {folder}" for folder in sorted(folders - lines.keys())]
            + [f"{PAGE}: {folder}/{first} does not exist" for folder, first in sorted(lines.items())
               if not exists(f"{folder}/{first}")])


def finds_its_own_example():
    page = "- `core` (`step.h`): one step\n- `hal/gone` (`bus.h`): buses\n"
    return complaints(page, {"core", "sim/rig"}, lambda path: path == "core/step.h") == [
        f"{PAGE}: no line for the folder sim/rig", f"{PAGE}: hal/gone/bus.h does not exist"]


def main(source):
    folders = folders_of(source)
    found = complaints((source / PAGE).read_text(), folders, lambda path: (source / path).exists())
    return verdict("check_folders.py", finds_its_own_example(), found, folders,
                   f"{len(folders)} folders, each with its line in {PAGE}")


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
