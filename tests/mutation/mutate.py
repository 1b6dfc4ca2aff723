#!/usr/bin/env python3
"""Mutation score of the code that takes the torque away: supervisor, supervision, limits, watchdog, gaps.

Changes one operator, constant, condition, statement or pair of arguments at a time, compiles the changed file,
links it with the tests of hal and runs them. A mutant that no test fails on survives. The release build of
test_hal must exist. Mutants that cannot be told from the original are listed in equivalent.txt, with the reason.
"""

import argparse
import json
import pathlib
import random
import re
import resource
import shlex
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
TARGETS = {
    "hal/rig/supervise.cc": "supervise",
    "hal/rig/supervisor.cc": "supervise",
    "hal/drive/drive.cc": "limits",
    "hal/rig/watchdog.cc": "watchdog",
    "hal/joint/encoder.cc": "gaps",
}
HEADERS = ["hal/rig/rig.h", "hal/rig/watchdog.h"]  # compiled once
# Tests that use none of the targets, and those that take longest, which run last.
UNRELATED = "StampClock*:PoseTrack*:Ndi*:CanTiming*:Polhemus*:Candump*:EncoderBoard*"
LONG = "Explored*:Sweep*"
SWAPS = [("<=", "<"), (">=", ">"), ("==", "!="), ("!=", "=="), ("&&", "||"), ("||", "&&"), ("+=", "-="), ("++", "--")]
SINGLE = [("<", "<="), (">", ">="), ("+", "-"), ("-", "+"), ("*", "/"), ("/", "*")]
WORDS = [("true", "false"), ("false", "true"), ("min", "max"), ("max", "min"), ("all_of", "any_of"),
         ("any_of", "all_of"), ("none_of", "any_of"), ("armed", "ready"), ("enabling", "booting"),
         ("run_down", "normal"), ("at_once", "run_down"), ("hold", "enable")]
STATEMENT = re.compile(r"^ *(?:if \([^;{}]*\) |else )?((?:[\w.:>\[\]-]+\()[^;{}]*;|[\w.>\[\]-]+ (?:=|\+=) [^;{}]*;|\+\+[\w.]+;)$")
CONDITION = re.compile(r"\bif \((?!constexpr)")
ARGUMENTS = re.compile(r"(?<=\()([\w.:*]+), ([\w.:*]+)(?=[,)])")


def blank(text: str) -> str:
    """Returns the text with comments, strings, characters and directives replaced by blanks."""
    def spaces(found: re.Match) -> str:
        return re.sub(r"[^\n]", " ", found.group())
    return re.sub(r'//[^\n]*|"(?:\\.|[^"\\\n])*"|^#[^\n]*|/\*.*?\*/', spaces, text, flags=re.S | re.M)


def closing(code: str, start: int) -> int:
    """Returns the position of the parenthesis that closes the one at start."""
    depth = 0
    for i in range(start, len(code)):
        depth += {"(": 1, ")": -1}.get(code[i], 0)
        if depth == 0:
            return i
    return len(code)


def sites(text: str) -> list[tuple[int, int, str, str]]:
    """Returns the mutants of a file: start, end, new text, name."""
    code, found = blank(text), []
    begin = code.find("namespace godobject")

    def add(start: int, end: int, new: str, name: str) -> None:
        if start >= begin and text[start:end] != new:
            found.append((start, end, new, name))

    for old, new in SWAPS:
        for at in re.finditer(re.escape(old), code):
            add(at.start(), at.end(), new, f"{old} to {new}")
    for old, new in SINGLE:
        for at in re.finditer(rf" {re.escape(old)} ", code):
            add(at.start() + 1, at.end() - 1, new, f"{old} to {new}")
    for old, new in WORDS:
        for at in re.finditer(rf"\b{old}\b(?! *\()|(?<=::){old}\b", code):
            add(at.start(), at.end(), new, f"{old} to {new}")
    for at in re.finditer(r"(?<![\w.])(?<!e-)(\d[\d']*)(?![\w.'])", code):
        value = int(at.group().replace("'", ""))
        add(at.start(), at.end(), str(value + 1), f"{at.group()} to {value + 1}")
        if value > 0:
            add(at.start(), at.end(), str(value - 1), f"{at.group()} to {value - 1}")
    for at in re.finditer(r"(?<![\w.])\d+(?:\.\d+)?e-?\d+\b", code):
        add(at.start(), at.end(), f"2 * {at.group()}", f"{at.group()} doubled")
    for at in re.finditer(r"!(?=[\w(])", code):
        add(at.start(), at.end(), "", "! removed")
    for at in CONDITION.finditer(code):
        last = closing(code, at.end() - 1)
        add(at.end(), last, f"!({text[at.end():last]})", "condition negated")
    for at in ARGUMENTS.finditer(code):
        add(at.start(), at.end(), f"{at.group(2)}, {at.group(1)}", "arguments swapped")
    at_line = 0
    for line in code.splitlines(keepends=True):
        statement = STATEMENT.match(line.rstrip("\n"))
        if statement and "return" not in line:
            add(at_line + statement.start(1), at_line + statement.end(1), ";", "statement removed")
        at_line += len(line)
    return sorted(set(found))


def run(command: list[str], where: pathlib.Path, cpu_s: int = 300) -> bool:
    """Runs a command. Its time is bounded as processor time, which does not grow on a busy machine."""
    def bound() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (cpu_s, cpu_s))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        done = subprocess.run(command, cwd=where, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=20 * cpu_s,
                              check=False, preexec_fn=bound)
    except subprocess.TimeoutExpired:  # it waits: for a test that needs less than a second of processor time
        return False
    return done.returncode == 0


class Builder:
    """Compiles mutants with the flags of the release build, and links them with its tests."""

    def __init__(self, build: pathlib.Path, work: pathlib.Path):
        self.build, self.work = build, work
        listed = subprocess.run(["ninja", "-t", "commands", "tests/test_hal"], cwd=build, capture_output=True, text=True,
                                check=True).stdout.splitlines()
        library = [shlex.split(line) for line in listed if " -c " in line and "godobject_hal.dir" in line]
        if not library:
            sys.exit(f"mutate: {build} builds no hal: build its target test_hal first")
        self.flags = [word for word in library[0][: library[0].index("-MD")] if word not in ("ccache", "-Werror", "-O3")]
        self.sources = [pathlib.Path(command[-1]) for command in library]
        link = shlex.split(listed[-1].split("&&")[1])
        self.tests = [word for word in link if word.endswith(".o")]
        self.libraries = [word for word in link if word.endswith(".a") and "godobject_hal" not in word]
        self.rest: dict[str, list[str]] = {}
        self.headers = work / "headers.h"
        self.headers.write_text("".join(f'#include "{name}"\n' for name in HEADERS))
        if not run([*self.flags, "-O1", "-w", "-x", "c++-header", "-o", f"{self.headers}.gch", "-c", str(self.headers)], build):
            sys.exit("mutate: the headers do not compile")

    def compile(self, source: pathlib.Path, out: pathlib.Path) -> bool:
        return run([*self.flags, "-O1", "-w", "-include", str(self.headers), "-o", str(out), "-c", str(source)], self.build)

    def rest_of(self, target: str) -> list[str]:
        """Returns the objects of the library without the target. A unity file that includes it is compiled anew."""
        if target in self.rest:
            return self.rest[target]
        objects = []
        for source in self.sources:
            text = source.read_text()
            if str(ROOT / target) not in text and not str(source).endswith(target):
                objects.append(f"hal/CMakeFiles/godobject_hal.dir/Unity/{source.name}.o")
                continue
            short = self.work / f"rest_{len(self.rest)}.cc"
            short.write_text("".join(line + "\n" for line in text.splitlines() if target not in line))
            if not self.compile(short, short.with_suffix(".o")):
                sys.exit(f"mutate: the library does not compile without {target}")
            objects.append(str(short.with_suffix(".o")))
        self.rest[target] = objects
        return objects

    def program(self, target: str, text: str) -> pathlib.Path | None:
        """Returns the test program with this text of the target; None if it does not compile."""
        source, program = self.work / "mutant.cc", self.work / "test_mutant"
        source.write_text(text)
        rest = self.rest_of(target)
        if not self.compile(source, source.with_suffix(".o")):
            return None
        linked = run(["c++", *self.tests, str(source.with_suffix(".o")), *rest, "-o", str(program), *self.libraries],
                     self.build)
        return program if linked else None


def passes(program: pathlib.Path) -> bool:
    """True if every test passes; the long ones run last. Bounds: ten times the processor time of the original."""
    return all(run([str(program), "--gtest_fail_fast", "--gtest_brief=1", f"--gtest_filter={filter_}"], program.parent, cpu_s)
               for filter_, cpu_s in ((f"-{LONG}:{UNRELATED}", 10), (LONG, 60)))


def line_of(text: str, at: int) -> int:
    return text.count("\n", 0, at) + 1


def equivalents() -> dict[str, str]:
    """Returns the reasons of equivalent.txt by 'file: name: source line'."""
    known = {}
    for line in (ROOT / "tests/mutation/equivalent.txt").read_text().splitlines():
        if line and not line.startswith("#"):
            mutant, reason = line.split(" ## ")
            known[mutant.strip()] = reason.strip()
    return known


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--mutants", type=int, default=500, help="number drawn of all (500)")
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    options.add_argument("--files", nargs="*", default=list(TARGETS), help="files to change (all)")
    options.add_argument("--seconds", type=float, default=float("inf"), help="stop drawing after so long")
    options.add_argument("--least", type=float, default=0.95, help="least score (0.95)")
    options.add_argument("--only", type=pathlib.Path, help="lines of an earlier run: only the mutants named in them")
    options.add_argument("--list", action="store_true", help="print the mutants, change nothing")
    options.add_argument("--json", type=pathlib.Path, help="write the result")
    given = options.parse_args()

    texts = {target: (ROOT / target).read_text() for target in given.files}
    mutants = [(target, *site) for target, text in texts.items() for site in sites(text)]
    random.Random(given.seed).shuffle(mutants)
    mutants = mutants[: given.mutants]
    known = equivalents()

    def name_of(mutant: tuple) -> str:
        target, start, _, _, name = mutant
        line = texts[target].splitlines()[line_of(texts[target], start) - 1].strip()
        column = start - texts[target].rfind("\n", 0, start)
        return f"{target}: {name} @{column}: {line}"

    if given.only:
        named = {line.removeprefix("survives: ") for line in given.only.read_text().splitlines()}
        mutants = [mutant for mutant in mutants if name_of(mutant) in named]
    if given.list:
        print("\n".join(map(name_of, mutants)))
        return 0
    began, killed, survivors, equal, invalid = time.monotonic(), 0, [], 0, 0
    with tempfile.TemporaryDirectory() as work:
        builder = Builder(given.build, pathlib.Path(work))
        for target, text in texts.items():
            program = builder.program(target, text)
            if program is None or not passes(program):
                sys.exit(f"mutate: the tests fail without a mutant of {target}")
        for number, mutant in enumerate(mutants):
            if number % 25 == 24:
                print(f"{number + 1} of {len(mutants)} after {time.monotonic() - began:.0f} s", flush=True)
            if time.monotonic() - began > given.seconds:
                break
            target, start, end, new, _ = mutant
            if name_of(mutant) in known:
                equal += 1
                continue
            program = builder.program(target, texts[target][:start] + new + texts[target][end:])
            if program is None:
                invalid += 1
            elif passes(program):
                survivors.append(name_of(mutant))
                print("survives:", name_of(mutant), flush=True)
            else:
                killed += 1
    tried = killed + len(survivors)
    score = killed / tried if tried else 1.0
    print(f"{tried + equal + invalid} mutants, seed {given.seed}: {killed} killed, {len(survivors)} survive, {equal} equivalent, "
          f"{invalid} do not compile; score {100 * score:.1f} %; {time.monotonic() - began:.0f} s")
    if given.json:
        given.json.write_text(json.dumps({"killed": killed, "survivors": survivors, "equivalent": equal,
                                          "invalid": invalid, "score": score}, indent=1) + "\n")
    return 0 if score >= given.least else 1


if __name__ == "__main__":
    sys.exit(main())
