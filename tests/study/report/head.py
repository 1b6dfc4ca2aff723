#!/usr/bin/env python3
"""Writes the head of the report, one table and one figure, from the tables of its sections.

usage: head.py [--check] REPORT

--check: fails if the head is not that of the sections; writes nothing. Needs gnuplot without --check.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

from sections import split

SCENES = {"S1": "rigid tool", "S3": "grasper", "S5": "five links"}
OURS = ("implicit-euler", "tr-bdf2")
ENGINES = ("MuJoCo 2.2", "Bullet 3.24", "ODE 0.16")  # in the table of steps
NONE = "none so fast"  # cell of a table
COLOURS = {"implicit-euler": "#7b1fa2", "tr-bdf2": "#2e7d32", "MuJoCo 2.2": "#00acc1", "Bullet 3.24": "#777777", "ODE 0.16": "#daa520",
           "Simbody 3.7": "#ad1457"}


def cells_of(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def table(text, heading, first_cells):
    """Returns the rows, as lists of cells, of the table below a heading whose head begins with these cells."""
    at = text.find(f"\n{heading}\n")
    lines = text[at:].splitlines() if at >= 0 else []
    for i, line in enumerate(lines):
        if line.startswith("|") and cells_of(line)[: len(first_cells)] == first_cells:
            rows = []
            for row in lines[i + 2:]:
                if not row.startswith("|"):
                    return rows
                rows.append(cells_of(row))
    sys.exit(f"head.py: the report has no table {first_cells} below '{heading}': write it with ./dev study")


def found(pattern, text):
    match = re.search(pattern, text)
    if not match:
        sys.exit(f"head.py: the report has no '{pattern}': write it with ./dev study")
    return match


def joined(items):
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"


def whole(value):
    """Returns a ratio with two significant digits, without an exponent."""
    return f"{float(f'{value:.2g}'):g}"


def times_text(ratio):
    """Returns 'N times' from a cell 'N (engine)', N maybe a bound, and the engine."""
    bound, value, engine = re.match(r"([<>]?) ?([\d.e+-]+) \((.*)\)$", ratio).groups()
    return {"": "", "<": "at most ", ">": "at least "}[bound] + f"{whole(float(value))} times", engine


def winners(line):
    """Returns 'engine (scenes)' for each engine in a line of the section about other engines."""
    scenes = {}
    for scene, engine in re.findall(r"(S\d|bag)[^;(]*\(([A-Za-z]+ ?[\d.]*)", line):
        scenes.setdefault(engine.strip(), set()).add(scene)
    return joined([f"{engine} ({', '.join(sorted(on))})" for engine, on in scenes.items()])


class Report:
    """The numbers of the sections."""

    def __init__(self, text):
        self.text = text
        self.errors = {(r[0], r[1]): r for r in table(text, "### 1. Error against run time", ["scene", "integrator"])}
        self.parts = table(text, "### 3. Footprint", ["part", "from"])
        self.map = table(text, "## Stability map", ["family", "silent"])
        self.peers = table(text, "## Beside other engines", ["engine", "S1, m"])
        self.work = table(text, "## Beside other engines", ["scene", "ours"])
        self.bricks = table(text, "## Beside other engines", ["engine", "S4, m"])
        self.nets = table(text, "## Beside other engines", ["engine", "S6"])
        self.cells = {scheme: [int(n) for n in found(rf"- {scheme}: (\d+), (\d+), (\d+), (\d+)", text).groups()]
                      for scheme in (*OURS, "explicit")}

    def better_than(self, integrator):
        """Returns which engines are better than one of our integrators, on which scenes; empty if none is."""
        at_1_ms = re.search(rf"\n- than {integrator}: (.*)", self.text)
        in_time = re.search(r"\n- in equal native time or to an equal error: (.*)", self.text)
        timed = re.findall(rf"S\d than {integrator} \([^;]*", in_time.group(1)) if in_time else []
        parts = [f"at a step of 1 ms {winners(at_1_ms.group(1))}"] if at_1_ms else []
        return "; ".join(parts + ([f"in equal native time or to an equal error {winners('; '.join(timed))}"] if timed else []))

    def first_line(self):
        parts = [f"than {integrator} {better}" for integrator in reversed(OURS) if (better := self.better_than(integrator))]
        if not parts:
            return "No other engine is better than ours, by 5 % or more."
        return f"**Other engines are better**, by 5 % or more: {'. Also '.join(parts)}."

    def time(self, engine, scene):
        """Returns the time of a step of 1 ms, us, of the run in which all native engines took turns."""
        return next(r for r in self.peers if r[0] == engine)[3 + 3 * list(SCENES).index(scene)]

    def accurate(self):
        parts = []
        for scene, name in SCENES.items():
            euler, second = (float(self.errors[scene, scheme][2]) for scheme in OURS)
            parts.append(f"{name} ({scene}) {second:.2g} m, {whole(euler / second)} times")
        return f"tr-bdf2 at 1 ms, and how much less than implicit Euler's: {'; '.join(parts)}"

    def fast(self):
        parts = []
        for scene, name in SCENES.items():
            times = [float(self.time(scheme, scene)) for scheme in OURS]
            counts = [self.errors[scene, scheme][9] for scheme in OURS]
            parts.append(f"{name} {times[0]:.2g} / {times[1]:.2g} us ({' / '.join(counts)} instructions)")
        return f"a step with implicit Euler / tr-bdf2: {'; '.join(parts)}"

    def stable(self):
        number = f"{sum(self.cells['tr-bdf2']):d}"
        drawn = found(r"stability-map --seed \d+ --samples (\d+)", self.text).group(1)
        silent = [sum(int(r[1].split(", ")[i]) for r in self.map) for i in (0, 1)]
        most = float(found(r"Silent, worst first: \d+ \(([\d.e-]+)\)", self.text).group(1))
        rise = found(r"tr-bdf2 gains at most ([\d.e+-]+) of the first energy", self.text).group(1)
        gains = self.cells["implicit-euler"][2]
        return (f"of {number} cells of stiffness, step, damping and inertia {gains} gain energy with implicit Euler, "
                f"{self.cells['tr-bdf2'][2]} with tr-bdf2, by at most {rise} of the first; none fails. Of {drawn} scenes drawn far "
                f"outside comfort {silent[0]} / {silent[1]} gain 0.1 % or more without a report, at most {100 * most:.2g} %")

    def cost(self):
        least = found(r"has (\d+) bytes of data, (\d+) of code and \d+ of constants, and (\d+) instructions a step", self.text).groups()
        parts = "; ".join(f"{r[0]} {r[3]} and {r[4]} bytes, {r[6]} instructions" for r in self.parts[:4])
        return f"data and code: the smallest step {least[0]} and {least[1]} bytes, {least[2]} instructions; {parts}"

    def compared(self):
        ratios = {r[0]: r[2] for r in self.work if r[1] == "tr-bdf2"}
        equal = "; ".join(f"{scene} {'no other is so fast' if ratio == NONE else '{} ({})'.format(*times_text(ratio))}"
                          for scene, ratio in ratios.items())
        ours = float(next(r[3] for r in self.bricks if r[0] == "implicit-euler"))
        native = [(float(r[3]), r[0]) for r in self.bricks if r[0] != "implicit-euler" and not r[3].endswith("W")]
        bricks = min(native)
        return (f"error of the best native engine in the time of our step of 1 ms, over ours: {equal}. 64 bricks (S4): "
                f"{ours:.3g} us, the fastest other {bricks[0]:.3g} us ({bricks[1]})")

    def head(self):
        rows = [("How accurate?", self.accurate(), "#1-error-against-run-time"), ("How fast?", self.fast(), "#1-error-against-run-time"),
                ("How stable?", self.stable(), "#stability-map"), ("At what cost?", self.cost(), "#3-footprint"),
                ("Compared with whom?", self.compared(), "#beside-other-engines")]
        lines = "".join(f"| [{question}]({section}) | {answer} |\n" for question, answer, section in rows)
        return f"{self.first_line()}\n\n| question | answer |\n|---|---|\n{lines}\n![in one figure](figures/overview.png)\n\n"

    def draw(self, png):
        """Draws errors over times of a step, the share of stable cells, and the parts' instructions."""
        native = [r for r in self.peers if "(mean velocity)" not in r[0] and not any(c.endswith("W") for c in r)]
        data = "".join(f"$e{i} << EOD\n{self.points(scene, native)}EOD\n" for i, scene in enumerate(SCENES))
        data += "$stable << EOD\n" + "".join(f'"{s}" {" ".join(str(100 * n / sum(c)) for n in c)}\n' for s, c in self.cells.items()) + "EOD\n"
        data += "$parts << EOD\n" + "".join(f'"{r[0].split(",")[0]}" {int(r[6])}\n' for r in self.parts) + "EOD\n"

        def lines(place):
            """Returns a plot of points by engine; place: a function of the number of an engine, for its 'using'."""
            return "plot " + ", ".join(f"{place(k)} with points pt 7 ps {1.5 if name in OURS else 1} lc rgb '{colour}' title '{name}'"
                                       for k, (name, colour) in enumerate(COLOURS.items())) + "\n"

        panels = "".join(f"set title '{scene}, {name}: error and time at 1 ms'\n"
                         + lines(lambda k, i=i: f"$e{i} using (column(3) == {k} ? $1 : NaN):2") for i, (scene, name) in enumerate(SCENES.items()))
        script = f"""{data}
set terminal pngcairo size 1080,640 font 'sans,9'
set output '{png}'
set multiplot layout 2,3
unset key
set grid
set logscale xy
set format y '10^{{%T}}'
set format x '%g'
set xlabel 'us of a step'
set ylabel 'worst error, m'
set offsets graph 0.1, graph 0.1, graph 0.1, graph 0.1
{panels}
unset logscale
unset offsets
set format y '%g'
set key below
set style data histograms
set style histogram rowstacked
set style fill solid 0.8 border -1
set boxwidth 0.6
set xlabel ''
set ylabel '% of the cells'
set yrange [0:100]
set title 'stiffness, step, damping, inertia'
plot $stable using 2:xtic(1) title 'stable' lc rgb '#2e7d32', '' using 3 title 'dissipative' lc rgb '#a5d6a7', \\
  '' using 4 title 'energy-gaining' lc rgb '#fb8c00', '' using 5 title 'failed' lc rgb '#c62828'
unset key
set yrange [0:*]
set style histogram clustered
set ylabel 'instructions'
set xtics rotate by -20
set title 'what a part adds to a step'
plot $parts using 2:xtic(1) lc rgb '#7b1fa2'
unset border
unset tics
unset xlabel
unset ylabel
set title ''
set key inside center center vertical samplen 1
set xrange [0:1]
set yrange [0:1]
{lines(lambda k: "NaN")}"""
        with tempfile.NamedTemporaryFile("w", suffix=".gp") as file:
            file.write(script)
            file.flush()
            subprocess.run(["gnuplot", file.name], check=True)

    @staticmethod
    def points(scene, rows):
        """Returns lines of time, error and number of the engine."""
        at = 1 + 3 * list(SCENES).index(scene)
        good = [r for r in rows if r[at] not in ("-", "fails") and r[at + 2] != "-"]
        return "".join(f"{r[at + 2]} {r[at]} {[r[0].startswith(name) for name in COLOURS].index(True)}\n" for r in good)


def main():
    arguments = [a for a in sys.argv[1:] if a != "--check"]
    if len(arguments) != 1:
        sys.exit(__doc__)
    path = pathlib.Path(arguments[0])
    before, head, after = split(path, "head")
    report = Report(before + head + after)
    if "--check" in sys.argv:
        if head != report.head():
            sys.exit(f"{path}: the head is not that of the sections: tests/study/report/head.py {path}")
        return
    path.write_text(before + report.head() + after)
    report.draw(path.parent / "figures/overview.png")


if __name__ == "__main__":
    main()
