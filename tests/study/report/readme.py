#!/usr/bin/env python3
"""Writes the README's table of steps, and the text below it, from the tables of the report.

usage: readme.py [--check] REPORT README

--check: fails if the README's section is not that of the report; writes nothing.
"""
import pathlib
import re
import sys
import textwrap

from head import ENGINES, NONE, OURS, SCENES, Report, found, joined, table, times_text, whole, winners
from sections import split


def time_text(us):
    if us < 100:
        return f"{us:.2g} us"
    return f"{us:.0f} us" if us < 1000 else f"{us / 1000:.2g} ms"


def ratio_text(ratio):
    return f"{ratio:.1f}" if ratio < 9.95 else whole(ratio)


def time_of(rows, engine, column):
    """Returns the time of an engine's fastest native setting, us; None if it has none on the scene."""
    times = [float(r[column]) for r in rows if r[0].startswith(engine) and r[column] != "-" and not r[column].endswith("W")]
    return min(times, default=None)


class Steps:
    """The times of the report, us: of our integrators, then of the other engines."""

    def __init__(self, report):
        self.report = report
        self.benchmarks = table(report.text, "## Steps of the benchmarks", ["step", *OURS, *ENGINES])

    def of_scene(self, name, rows, column):
        return name, [time_of(rows, engine, column) for engine in (*OURS, *ENGINES)]

    def of_benchmarks(self):
        return [(row[0], [None if cell == "-" else float(cell) for cell in row[1:]]) for row in self.benchmarks]

    def all(self):
        report = self.report
        scenes = [self.of_scene(f"{name}, {scene}", report.peers, 3 + 3 * i) for i, (scene, name) in enumerate(SCENES.items())]
        return [*scenes, *self.of_benchmarks(), self.of_scene("64 bricks, S4", report.bricks, 3),
                self.of_scene("hanging net of 1024 nodes, S6", report.nets, 2)]

    def line(self, name, times):
        cells = [time_text(time) if time else "" for time in times]
        for i in range(len(OURS), len(times)):
            if times[i]:
                cells[i] += f" ({ratio_text(times[i] / times[0])})"
        return f"| {' | '.join([name, *cells])} |".replace("|  |", "| |").replace("|  |", "| |")

    def table(self):
        head = f"| step | godobject | TR-BDF2 | {' | '.join(ENGINES)} |\n|---|---|---|---|---|---|\n"
        return head + "".join(f"{self.line(name, times)}\n" for name, times in self.all())

    def text(self):
        machine = found(r"in interleaved rounds on (.*?); those", self.report.text).group(1)
        fewer = [float(self.report.errors[s, OURS[0]][2]) / float(self.report.errors[s, OURS[1]][2]) for s in SCENES]
        times = (f"Medians on {machine}, of an engine's fastest setting; in brackets, times implicit Euler's (first column). "
                 f"At 1 ms TR-BDF2 errs {whole(min(fewer))} to {whole(max(fewer))} times less on {joined(list(SCENES))}.")
        return textwrap.fill(f"{times} {self.equal_time()} {self.losses()} ([report](docs/report.md#beside-other-engines)).", 119,
                             break_on_hyphens=False)

    def equal_time(self):
        """Returns a sentence on the best native engine in the time of a step of TR-BDF2 of 1 ms."""
        ratios = {r[0]: r[2] for r in self.report.work if r[1] == OURS[1]}
        times = [f"{times_text(ratio)[0]} ({scene})" for scene, ratio in ratios.items() if ratio != NONE]
        slower = [scene for scene, ratio in ratios.items() if ratio == NONE]
        line = f"In equal native time the best other engine errs {joined(times)} more" if times else ""
        none = f"none is so fast on {joined(slower)}" if slower else ""
        return f"{'; '.join(part for part in (line, none) if part)}."

    def losses(self):
        lines = re.findall(r"\n- (?:than [a-z0-9-]+|in equal native time or to an equal error): (.*)", self.report.text)
        return f"Others win in a number or more: {winners('; '.join(lines))}" if lines else "No other wins in a number"

    def section(self):
        return f"{self.table()}\n{self.text()}\n"


def main():
    arguments = [a for a in sys.argv[1:] if a != "--check"]
    if len(arguments) != 2:
        sys.exit(__doc__)
    report, readme = arguments
    before, section, after = split(readme, "steps")
    composed = Steps(Report(pathlib.Path(report).read_text())).section()
    if "--check" not in sys.argv:
        pathlib.Path(readme).write_text(before + composed + after)
    elif section != composed:
        sys.exit(f"{readme}: its table of steps is not that of the report: tests/study/report/readme.py {report} {readme}")


if __name__ == "__main__":
    main()
