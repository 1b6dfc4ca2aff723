#!/usr/bin/env python3
"""Mutation score of the code that takes the torque away: rig, supervisor, limits, watchdog, gaps.

Changes one operator, constant, condition, statement or pair of arguments at a time, compiles the changed file,
links it with the tests of hal and runs them. A mutant that no test fails on survives. The release build of
test_hal must exist. A mutant is equivalent if its machine code is that of the original, or if equivalent.txt lists
it with the reason.
"""

import argparse
import collections
import concurrent.futures
import json
import os
import pathlib
import queue
import random
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
TARGETS = [
    "hal/rig/supervise.cc", "hal/rig/supervisor.cc", "hal/rig/rig.cc", "hal/rig/request.cc", "hal/rig/receive.cc",  # supervise
    "hal/rig/homing.cc",
    "hal/drive/drive.cc",  # limits
    "hal/rig/watchdog.cc",
    "hal/joint/encoder.cc",  # gaps
]
HEADERS = ["hal/rig/rig.h", "hal/rig/watchdog.h"]  # compiled once
# Flags of the build that clang lacks, or that only cost time. Clang instantiates the headers' templates once.
DROPPED = re.compile(r"-(O|W|mmove|mstore|mstring)")
CLANG = ["clang++", "-fpch-instantiate-templates"]
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
GUARD = re.compile(r"^ *(if \([^;{}]*\) (?:return|continue)\b[^;{}]*;)$")
CHOICE = re.compile(r"\? ([^?:;,()]+(?:\([^()]*\))?) : ([^?:;,()]+(?:\([^()]*\))?)(?=[;,)])")
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
    for at in CHOICE.finditer(code):
        add(at.start(1), at.end(2), f"{text[at.start(2):at.end(2)]} : {text[at.start(1):at.end(1)]}", "alternatives swapped")
    at_line = 0
    for line in code.splitlines(keepends=True):
        statement, guard = STATEMENT.match(line.rstrip()), GUARD.match(line.rstrip())
        if statement and "return" not in line:
            add(at_line + statement.start(1), at_line + statement.end(1), ";", "statement removed")
        if guard:
            add(at_line + guard.start(1), at_line + guard.end(1), ";", "guard removed")
        at_line += len(line)
    return sorted(set(found))


def run(command: list[str], where: pathlib.Path, cpu_s: int = 300) -> bool:
    """Runs a command. Its time is bounded as processor time, which does not grow on a busy machine."""
    try:
        done = subprocess.run(["prlimit", f"--cpu={cpu_s}", "--core=0", *command], cwd=where, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, timeout=20 * cpu_s, check=False)
    except subprocess.TimeoutExpired:  # it waits: for a test that needs less than a second of processor time
        return False
    return done.returncode == 0


class Builder:
    """Compiles mutants with the flags of the release build, and links them with its tests."""

    def __init__(self, build: pathlib.Path, work: pathlib.Path, pool: concurrent.futures.Executor):
        self.build, self.work = build, work
        listed = subprocess.run(["ninja", "-t", "commands", "tests/test_hal"], cwd=build, capture_output=True, text=True,
                                check=True).stdout.splitlines()
        library = [shlex.split(line) for line in listed if " -c " in line and "godobject_hal.dir" in line]
        if not library:
            sys.exit(f"mutate: {build} builds no hal: build its target test_hal first")
        words = library[0][: library[0].index("-MD")]
        first = next(i for i, word in enumerate(words) if word.startswith("-"))  # after the compiler
        compiler = CLANG if shutil.which("clang++") else words[first - 1: first]
        self.flags = [*compiler, *(word for word in words[first:] if not DROPPED.match(word)), "-O1", "-w"]
        link = shlex.split(listed[-1].split("&&")[1])
        self.tests = [word for word in link if word.endswith(".o")]
        self.libraries = [word for word in link if word.endswith(".a") and "godobject_hal" not in word]
        self.linker = ["c++", "-fuse-ld=mold"] if shutil.which("mold") else ["c++"]
        self.headers = work / "headers.h"
        self.headers.write_text("".join(f'#include "{name}"\n' for name in HEADERS))
        header = [*self.flags, "-x", "c++-header", "-o", f"{self.headers}.gch", "-c", str(self.headers)]
        rest = [work / f"rest_{i}.cc" for i in range(len(library))]  # unity files without the targets
        for source, command in zip(rest, library):
            lines = pathlib.Path(command[-1]).read_text().splitlines()
            source.write_text("\n".join(line for line in lines if not any(target in line for target in TARGETS)))
        self.targets = {target: work / pathlib.Path(target).with_suffix(".o").name for target in TARGETS}
        self.rest = [str(source.with_suffix(".o")) for source in rest]
        if not run(header, build) or not all(pool.map(self.compile, [*rest, *(ROOT / target for target in TARGETS)],
                                                      [*self.rest, *self.targets.values()])):
            sys.exit("mutate: the library does not compile")

    def compile(self, source: pathlib.Path, out: pathlib.Path | str) -> bool:
        return run([*self.flags, "-include", str(self.headers), "-o", str(out), "-c", str(source)], self.build)

    def code(self, text: str, work: pathlib.Path) -> bytes | None:
        """Returns the object file of this text of a target, compiled in the folder work; None if it does not compile."""
        source, out = work / "mutant.cc", work / "mutant.o"
        source.write_text(text)
        return out.read_bytes() if self.compile(source, out) else None

    def program(self, target: str, work: pathlib.Path) -> pathlib.Path | None:
        """Returns the test program with the target as last compiled in the folder work; None if it does not link."""
        program = work / "test_mutant"
        others = [str(object_) for name, object_ in self.targets.items() if name != target]
        linked = run([*self.linker, *self.tests, str(work / "mutant.o"), *others, *self.rest, "-o", str(program),
                      *self.libraries], self.build)
        return program if linked else None


def passes(program: pathlib.Path) -> bool:
    """True if every test passes; the long ones run last. Bounds: ten times the processor time of the original."""
    return all(run([str(program), "--gtest_fail_fast", "--gtest_brief=1", f"--gtest_filter={filter_}"], program.parent, cpu_s)
               for filter_, cpu_s in ((f"-{LONG}:{UNRELATED}", 5), (LONG, 30)))


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
    options.add_argument("--files", nargs="*", default=TARGETS, help="files to change (all)")
    options.add_argument("--seconds", type=float, default=float("inf"), help="stop drawing after so long")
    options.add_argument("--jobs", type=int, default=os.cpu_count(), help="mutants at a time (one per processor)")
    options.add_argument("--least", type=float, default=0.95, help="least score (0.95)")
    options.add_argument("--only", type=pathlib.Path, help="lines of an earlier run: only the mutants named in them")
    options.add_argument("--list", action="store_true", help="print the mutants, change nothing")
    options.add_argument("--json", type=pathlib.Path, help="write the result")
    options.add_argument("--survivors", type=pathlib.Path, help="write the mutants that survive, one a line")
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
    began, outcomes, survivors = time.monotonic(), collections.Counter(), []
    with tempfile.TemporaryDirectory() as work, concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
        builder = Builder(given.build, pathlib.Path(work), pool)
        folders: queue.Queue[pathlib.Path] = queue.Queue()
        places = [pathlib.Path(work, str(job)) for job in range(given.jobs)]
        for place in places:
            place.mkdir()
            folders.put(place)
        originals: dict[str, set[bytes | None]] = {}  # code of each target, by folder

        def outcome_of(target: str, text: str) -> str:
            folder = folders.get()
            try:
                code = builder.code(text, folder)
                if code is None:
                    return "invalid"
                if code in originals.get(target, set()):
                    return "equivalent"
                program = builder.program(target, folder)
                return "invalid" if program is None else "survives" if passes(program) else "killed"
            finally:
                folders.put(folder)

        def try_out(mutant: tuple) -> str:
            target, start, end, new, _ = mutant
            if name_of(mutant) in known:
                return "equivalent"
            if time.monotonic() - began > given.seconds:
                return "left out"
            return outcome_of(target, texts[target][:start] + new + texts[target][end:])

        for target, text in texts.items():
            if outcome_of(target, text) != "survives":
                sys.exit(f"mutate: the tests fail without a mutant of {target}")
            originals[target] = {builder.code(text, place) for place in places}
        for number, (mutant, outcome) in enumerate(zip(mutants, pool.map(try_out, mutants)), 1):
            outcomes[outcome] += 1
            if outcome == "survives":
                survivors.append(name_of(mutant))
                print("survives:", name_of(mutant), flush=True)
            if number % 25 == 0:
                print(f"{number} of {len(mutants)} after {time.monotonic() - began:.0f} s", flush=True)
    killed, left_out = outcomes["killed"], outcomes["left out"]
    score = killed / (killed + len(survivors)) if killed + len(survivors) else 1.0
    result = (f"{len(mutants) - left_out} mutants, seed {given.seed}: {killed} killed, {len(survivors)} survive, "
              f"{outcomes['equivalent']} equivalent, {outcomes['invalid']} do not compile; score {100 * score:.1f} %")
    print(f"{result}; {time.monotonic() - began:.0f} s")
    if given.json:
        given.json.write_text(json.dumps({"result": result, "killed": killed, "survivors": survivors, "score": score}, indent=1) + "\n")
    if given.survivors:
        given.survivors.write_text("".join(f"{name}\n" for name in sorted(survivors)))
    return 0 if score >= given.least else 1


if __name__ == "__main__":
    sys.exit(main())
