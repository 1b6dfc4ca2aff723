#!/usr/bin/env python3
"""Every equation number cited in a comment of core stands in docs/step.md, and the reverse.

usage: check_equations.py SOURCE_DIR
"""
import pathlib
import re
import sys


def cited_in_core(core):
    cited = {}
    for path in sorted(core.rglob("*.h")):
        for number, line in enumerate(path.read_text().splitlines(), 1):
            comment = line.partition("//")[2]
            for equation in re.findall(r"\((\d+)\)", comment):
                cited.setdefault(int(equation), f"{path.name}:{number}")
    return cited


def main(source):
    cited = cited_in_core(source / "core")
    defined = set()
    for group in re.findall(r"^((?:\*\*\(\d+\)\*\*,? ?)+)", (source / "docs/step.md").read_text(), re.M):
        defined |= {int(n) for n in re.findall(r"\((\d+)\)", group)}
    wrong = [f"({n}) is cited at core/{place} and not in docs/step.md" for n, place in cited.items() if n not in defined]
    wrong += [f"({n}) stands in docs/step.md and is cited nowhere in core" for n in sorted(defined - cited.keys())]
    print("\n".join(wrong) or f"{len(defined)} equations, all cited both ways")
    return 1 if wrong or not defined else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
