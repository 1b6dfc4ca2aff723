#!/usr/bin/env python3
"""Runs the commands of a page of docs/tutorials or docs/how-to as a reader types them, and compares the output it shows.

usage: run_page.py --source SOURCE_DIR --program GODOBJECT [--build BUILD_DIR] PAGE
       run_page.py --self-test

The page is Markdown. Its fenced blocks are followed from top to bottom, in a new folder that has the source tree's
folders as links; the info string of a block (which a reader does not see) says what is done:

  sh                      commands; they succeed, or end with the code of `exit=2`
  sh terminal=rig         a command of a terminal of its own, left running; a later block of that terminal, or the end
                          of the page, presses Ctrl-C. The next block waits for its output; where the output has the
                          address of a view, a client of it must receive frames
  toml file=my/a.toml     the block is written to the file; append=my/a.toml: at its end
  text                    lines that the output of the block before has, in this order; `...` stands for anything.
                          A /dev/pts/N of the page is from there on the terminal that was printed in its place
  console                 is not run: commands for another machine, or for root

A line `<!-- after: OTHER.md -->` names a page whose files the reader has: they are made first, and its `cp` is done.

Exit codes: 0 passed, 1 failed, 77 a command is missing on this machine.
"""
import argparse
import dataclasses
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import types

SKIPPED = 77
WAIT_S = 30  # for the output of a terminal, and for its end
COMMAND_S = 300  # for a block of commands; a compiler may be among them
ATTEMPTS = 4  # of a page in which a busy machine left the programs without their processor
STARVED = {"deadlines_missed", "held", "sample_stale", "drive_silent", "emergency", "drive_not_enabled"}  # by watchdogs

BLOCK = re.compile(r"^```(\S+)[ ]*(.*)\n((?:.*\n)*?)```$", re.M)
TERMINAL = re.compile(r"/dev/pts/\d+")
VIEW = re.compile(r"http://([\w.]+):(\d+)/\?token=(\w+)")
FAULT = re.compile(r"(?:FAULT |^(?=\w+ \(\w+ node \d))(\w+)", re.M)  # of `run`, and of a RigRun
AFTER = re.compile(r"^<!-- after: (\S+) -->$", re.M)
MODULE = "module godobject._core in its build"
TOOLS = {"gnuplot", "g++", "cmake", "ninja"}  # of Debian; a page that needs a missing one is skipped


class Failed(Exception):
    pass


class Starved(Failed):
    """Ended by faults that a busy machine makes, and no others."""


@dataclasses.dataclass
class Block:
    line: int
    language: str
    options: dict
    text: str


def blocks_of(page):
    for found in BLOCK.finditer(page):
        options = dict(word.partition("=")[::2] for word in shlex.split(found[2]))
        yield Block(page.count("\n", 0, found.start()) + 1, found[1], options, found[3])


class Reader:
    """Follows one page in a folder."""

    def __init__(self, folder, environment):
        self.folder, self.environment = pathlib.Path(folder), environment
        self.terminals = {}  # name: process
        self.logs = []  # of all terminals
        self.paths = {}  # /dev/pts/N of the page: here
        self.output = lambda: ""  # of the command before, as far as it is there
        self.waits = False  # that command is still running

    def here(self, text):
        return TERMINAL.sub(lambda path: self.paths.get(path[0], path[0]), text)

    def follow(self, block):
        options = block.options
        if "file" in options or "append" in options:
            path = self.folder / (options.get("file") or options["append"])
            path.parent.mkdir(parents=True, exist_ok=True)
            with open(path, "a" if "append" in options else "w") as file:
                file.write(self.here(block.text))
        elif block.language == "sh" and "terminal" in options:
            self.open_terminal(options["terminal"], self.here(block.text))
        elif block.language == "sh":
            self.run(self.here(block.text), int(options.get("exit", 0)))
        elif block.language == "text":
            self.compare(block.text)

    def run(self, commands, wanted):
        done = subprocess.run(["bash", "-ec", commands], cwd=self.folder, env=self.environment, text=True, errors="replace",
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=COMMAND_S)
        self.output, self.waits = lambda: done.stdout, False
        if done.returncode != wanted:
            kind = Starved if is_starved(done.stdout) else Failed
            raise kind(f"exit code {done.returncode}, not {wanted}:\n{commands}{done.stdout}")

    def open_terminal(self, name, command):
        self.close_terminal(name)
        log = self.folder / f".{name}-{time.monotonic_ns()}"
        with open(log, "wb") as out:
            process = subprocess.Popen(["bash", "-c", "exec " + command.strip()], cwd=self.folder, env=self.environment,
                                       stdin=subprocess.DEVNULL, stdout=out, stderr=out)
        self.terminals[name] = process
        self.logs.append(log)
        self.output, self.waits = lambda: log.read_text(errors="replace"), True
        if "--view" in command:
            self.look(process)

    def close_terminal(self, name):
        process = self.terminals.pop(name, None)
        if process is None:
            return
        process.send_signal(signal.SIGINT)
        try:
            process.wait(WAIT_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            raise Failed(f"Ctrl-C does not end terminal '{name}' within {WAIT_S} s")

    def close(self):
        for name in list(self.terminals):
            self.close_terminal(name)

    def wait_for(self, condition, wanted):
        end = time.monotonic() + (WAIT_S if self.waits else 0)
        while not (value := condition()):
            if time.monotonic() >= end:
                raise Failed(f"the output has not {wanted}:\n{self.output()}")
            time.sleep(0.05)
        return value

    def look(self, process):
        """As the browser does: the scene, then frames that go on."""
        found = self.wait_for(lambda: VIEW.search(self.output()) or process.poll() == 3, "the address of the view")
        if found is True:
            skip(self.output())
        sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "view"))
        from viewed_run import Stream
        stream = Stream(types.SimpleNamespace(host=found[1], port=int(found[2]), token=found[3]))
        stream.scene()
        first = stream.frame()["cycle"]
        for _ in range(200):
            if stream.frame()["cycle"] > first:
                break
        else:
            raise Failed("the view stands still")
        stream.close()

    def compare(self, wanted):
        """Every line in its order; the terminals of its paths are remembered."""
        groups, pattern = [], []
        for line in wanted.splitlines():
            if line.strip() == "...":
                continue
            parts = []
            for part in re.split(r"(/dev/pts/\d+|\.\.\.)", line.rstrip()):
                if part == "...":
                    parts.append(".*?")
                elif TERMINAL.fullmatch(part):
                    groups.append(part)
                    parts.append(r"(/dev/pts/\d+)")
                else:
                    parts.append(re.escape(part))
            pattern.append(r"^[ \t]*" + "".join(parts) + r"[ \t]*$")
        search = re.compile(r"(?:.*\n)*?".join(p + r"\n?" for p in pattern), re.M)
        found = self.wait_for(lambda: search.search(self.output()), f"the lines of the page\n{wanted}")
        self.paths.update(zip(groups, found.groups()))


def is_starved(output):
    """True if it names faults that a busy machine makes, and no others."""
    faults = set(FAULT.findall(output))
    return bool(faults) and faults <= STARVED


def skip(why):
    print("skipped:", why)
    sys.exit(SKIPPED)


def files_of(page):
    """The blocks that make files of a page, and of the page that comes before."""
    for block in blocks_of(page):
        copies = "".join(line + "\n" for line in block.text.splitlines() if line.startswith("cp "))
        if "file" in block.options or "append" in block.options:
            yield block
        elif block.language == "sh" and copies:
            yield dataclasses.replace(block, text=copies, options={})


def follow_page(text, source=None, program=None, build=None, before=""):
    with tempfile.TemporaryDirectory(prefix="godobject-page-") as made:
        folder = pathlib.Path(made) / "godobject"
        folder.mkdir()
        for entry in source.iterdir() if source else []:
            if not entry.name.startswith(".") and entry.name not in ("build", "out", "my"):
                (folder / entry.name).symlink_to(entry)
        home = pathlib.Path(made) / "home"
        home.mkdir()
        if build:
            (folder / "build").mkdir()
            (folder / "build/release").symlink_to(build)
        environment = dict(os.environ, HOME=str(home), XDG_RUNTIME_DIR=str(home), PYTHONDONTWRITEBYTECODE="1")
        path = [str(program.parent)] if program else []
        if python := python_for_hil():  # Debian's, where another one is first in the path
            (home / "bin").mkdir()
            (home / "bin/python3").symlink_to(python)
            path.insert(0, str(home / "bin"))
        environment["PATH"] = ":".join([*path, environment["PATH"]])
        reader = Reader(folder, environment)
        try:
            for block in [*files_of(before), *blocks_of(text)]:
                try:
                    reader.follow(block)
                except Failed as failed:
                    reader.close()  # a run prints its faults at its end
                    starved = isinstance(failed, Starved) or any(is_starved(log.read_text(errors="replace")) for log in reader.logs)
                    raise (Starved if starved else Failed)(f"line {block.line}: {failed}") from None
        finally:
            reader.close()


def python_for_hil():
    """A Python with the packages of tests/hil, or None."""
    for python in ("/usr/bin/python3", sys.executable):
        if subprocess.run([python, "-c", "import pytest"], capture_output=True).returncode == 0:
            return python
    return None


def has_numpy(python):
    return subprocess.run([python, "-c", "import numpy"], capture_output=True).returncode == 0


def missing_tools(text, build=None):
    commands = "".join(b.text for b in blocks_of(text) if b.language == "sh")
    needed = {tool for tool in TOOLS if re.search(rf"^{re.escape(tool)} ", commands, re.M)}
    needed |= {"gnuplot"} if "./dev plot" in commands else set()
    needed |= {"python3-pytest"} if "pytest" in commands else set()
    needed |= {MODULE, "python3-numpy"} if "godobject.Scene(" in text else set()
    needed |= {"python3-numpy"} if "godobject.world" in text else set()

    def is_there(tool):
        if tool == MODULE:
            return build is not None and any((build / "platform/python/godobject").glob("_core*"))
        if tool == "python3-numpy":
            return has_numpy(python_for_hil() or "python3")
        return bool(python_for_hil()) if tool == "python3-pytest" else shutil.which(tool) is not None

    return sorted(tool for tool in needed if not is_there(tool))


SELF_TEST = [  # (page, whether it passes)
    ("```sh\necho one; echo two 5 mm\n```\n```text\none\ntwo ... mm\n```\n", True),
    ("```sh\necho one\n```\n```text\ntwo\n```\n", False),
    ("```sh\necho two; echo one\n```\n```text\none\ntwo\n```\n", False),
    ("```sh\nfalse\n```\n", False),
    ("```sh exit=1\nfalse\n```\n", True),
    ("```toml file=my/a.toml\na = 1\n```\n```toml append=my/a.toml\nb = 2\n```\n```sh\ncat my/a.toml\n```\n"
     "```text\na = 1\nb = 2\n```\n", True),
    ("```sh terminal=rig\nbash -c 'echo bus: /dev/pts/90; sleep 60'\n```\n```text\nbus: /dev/pts/7\n```\n"
     "```sh\necho to /dev/pts/7\n```\n```text\nto /dev/pts/7\n```\n", True),
    ("```console\nfalse\n```\n", True),
]


def self_test():
    for page, passes in SELF_TEST:
        try:
            follow_page(page)
            passed = True
        except Failed:
            passed = False
        if passed != passes:
            print(f"passes: {passed}, not {passes}:\n{page}")
            return 1
    print(f"{len(SELF_TEST)} pages of its own pass and fail as they should")
    return 0


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--self-test", action="store_true")
    parser.add_argument("--source", type=pathlib.Path)
    parser.add_argument("--program", type=pathlib.Path)
    parser.add_argument("--build", type=pathlib.Path, help="what build/release is")
    parser.add_argument("page", type=pathlib.Path, nargs="?")
    arguments = parser.parse_args()
    if arguments.self_test:
        return self_test()
    text = arguments.page.read_text()
    after = AFTER.search(text)
    before = (arguments.page.parent / after[1]).read_text() if after else ""
    if not any(block.language == "sh" for block in blocks_of(text)):
        print("no commands in it")
        return 1
    if missing := missing_tools(text, arguments.build):
        skip(f"this machine has no {', '.join(missing)}")
    for attempt in range(ATTEMPTS):
        try:
            follow_page(text, arguments.source, arguments.program, arguments.build, before)
            print(f"{sum(1 for _ in blocks_of(text))} blocks, as the page has them")
            return 0
        except Failed as failed:
            print(f"{arguments.page}: {failed}")
            if not isinstance(failed, Starved) or attempt == ATTEMPTS - 1:
                return 1


if __name__ == "__main__":
    sys.exit(main())
