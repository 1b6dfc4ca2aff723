#!/usr/bin/env python3
"""Each file that a comment names exists: beside the comment's own file, below it, or from one of the folders above it.

A name without a folder may also be that of a file anywhere, if no comment could mean another: step.md, rig.h. A pattern
such as test_touching_*.cc needs one file that it matches.

usage: check_named_files.py SOURCE_DIR
"""
import fnmatch
import pathlib
import re
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import comment_blocks

from verdict import verdict

NAMED = re.compile(r"(?<![\w/.<*-])((?:\.\./)*[\w*-][\w*/-]*\.(?:h|cc|js|py|md|cmake|toml|gp|csv))(?![\w/*])")
NOT_OURS = {"toml", "csv"}  # without a folder, such a name is an example


def files_of(source):
    return {str(path.relative_to(source)) for folder in (*comment_blocks.LAYERS, "docs") for path in (source / folder).rglob("*")
            if path.is_file()} | {path.name for path in source.iterdir() if path.is_file()}


def exists(name, path, files, base_names):
    """True if `name`, in a comment of the file `path`, names a file."""
    folder = pathlib.PurePosixPath(path).parent
    while name.startswith("../"):
        folder, name = folder.parent, name[3:]
    if any(mark in name for mark in "*"):
        return any(fnmatch.fnmatch(file, "*/" + name) for file in files)
    if any(str(above / name) in files for above in (folder, *folder.parents)):
        return True
    return name in base_names if "/" not in name else any(file.endswith("/" + name) for file in files)


def missing(source):
    """(number of names, places of those that name no file)."""
    files = files_of(source)
    base_names = {pathlib.PurePosixPath(file).name for file in files}
    checked, found = 0, []
    for path in comment_blocks.sources(source):
        for block in comment_blocks.blocks(comment_blocks.read(source, path)):
            for match in NAMED.finditer(block.text):
                name = match.group(1)
                if "/" not in name and name.rpartition(".")[2] in NOT_OURS:
                    continue
                checked += 1
                if not exists(name, str(path), files, base_names):
                    line = block.line + block.text.count("\n", 0, match.start())
                    found.append(f"{path}:{line}: {name} does not exist")
    return checked, found


def finds_its_own_example():
    """The check itself: of six names the three without a file are found."""
    with tempfile.TemporaryDirectory() as made:
        source = pathlib.Path(made)
        for folder in ("core/net", "docs"):
            (source / folder).mkdir(parents=True)
        (source / "docs/step.md").write_text("")
        (source / "core/step.h").write_text('#include "gone.h"\n')
        (source / "core/net/a.h").write_text("// docs/step.md, core/step.h, net/a.h, gone.h.\nint a;  // find/b.h; test_*.cc\n")
        return missing(source) == (6, ["core/net/a.h:1: gone.h does not exist", "core/net/a.h:2: find/b.h does not exist",
                                       "core/net/a.h:2: test_*.cc does not exist"])


def main(source):
    checked, found = missing(source)
    return verdict("check_named_files.py", finds_its_own_example(), found, checked,
                   f"{checked} names of files in comments, each of a file")


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
