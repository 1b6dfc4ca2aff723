#!/usr/bin/env python3
"""Every relative link in a Markdown file of the repository points to something that exists.

usage: check_links.py SOURCE_DIR
"""
import pathlib
import re
import sys
import tempfile

from verdict import verdict

CODE = re.compile(r"^( *)(```|~~~).*?^ *\2|`[^`\n]*`", re.M | re.S)  # not Markdown inside
LINK = re.compile(r"\]\(<?([^)>\s]+)")  # [words](target), ![words](target)
REFERENCE = re.compile(r"^ {0,3}\[[^\]]+\]:\s*(\S+)", re.M)  # [name]: target
BUILT = {"build", "out", "node_modules"}  # not of the repository, as hidden directories


def pages(source):
    for path in sorted(source.rglob("*.md")):
        inside = path.relative_to(source).parts[:-1]
        if not any(part in BUILT or part.startswith(".") for part in inside):
            yield path


def broken_links(source):
    """(number of relative links, those that point nowhere)."""
    checked, broken = 0, []
    for page in pages(source):
        text = CODE.sub(lambda code: "\n" * code[0].count("\n"), page.read_text())
        for found in [*LINK.finditer(text), *REFERENCE.finditer(text)]:
            target = found[1].partition("#")[0]
            if not target or re.match(r"[a-z][a-z0-9+.-]*:", target):  # a place in this page; another site
                continue
            checked += 1
            if not (page.parent / target).exists():
                line = text.count("\n", 0, found.start()) + 1
                broken.append(f"{page.relative_to(source)}:{line}: {target} does not exist")
    return checked, broken


def finds_a_broken_one():
    """The check itself: of five links the two that point nowhere are told, with their lines."""
    with tempfile.TemporaryDirectory() as made:
        source = pathlib.Path(made)
        (source / "docs").mkdir()
        (source / "docs/there.md").write_text("[up](../README.md#top) ![no](no.png)\n")
        (source / "README.md").write_text(
            "[page](docs/there.md), [site](https://example.org/x.md), [here](#here), `[code](none.md)`\n"
            "```\n[code](none.md)\n```\n[gone](gone.md)\n[docs]: docs\n")
        checked, broken = broken_links(source)
        wanted = ["README.md:5: gone.md does not exist", "docs/there.md:1: no.png does not exist"]
        return checked == 5 and broken == wanted


def main(source):
    checked, broken = broken_links(source)
    return verdict("check_links.py", finds_a_broken_one(), broken, checked,
                   f"{checked} links, all of them to something that exists")


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
