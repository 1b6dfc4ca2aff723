#!/usr/bin/env python3
"""Measures the error of the core with float beside that with double, and writes its section of the report.

usage: float_core.py FOLDER_OF_PROGRAMS OUT_FOLDER [REPORT]

Programs: godobject-double, godobject-float. Without a report only OUT_FOLDER/float.csv and float.png are written.
"""
import math
import pathlib
import re
import shutil
import subprocess
import sys

from sections import split

SCENES = ("rigid", "grasper", "press")
REALS = ("double", "float")
REFERENCE_STEPS = 640  # of 1/32 ms, per row of 20 ms
STEPS_ms = {5: 4.0, 10: 2.0, 20: 1.0, 40: 0.5, 80: 0.25, 160: 0.125}  # steps per row: step
REPORTED_ms = (4.0, 1.0, 0.125)
TEXT = """## Float beside double

The core with `GODOBJECT_REAL=float` (docs/examples/microcontroller), scenes `rigid` (S1), `grasper` and `press` for 2 s with
tr-bdf2: worst errors of position and rotation every 20 ms against the core with double at 1/32 ms. Targets are computed in
the same numbers. All steps: `float.csv`; command: `./dev study --float`.

"""


def poses(program, scene, steps):
    """Returns the numbers of each pose, by row and body. Exits if the program reports a fault."""
    done = subprocess.run([program, scene, str(steps)], capture_output=True, text=True, timeout=600)
    if done.returncode != 0:
        sys.exit(f"{program} {scene} {steps}: exit code {done.returncode}")
    return {tuple(map(int, line.split(",")[:2])): [float(a) for a in line.split(",")[2:]] for line in done.stdout.split()}


def errors(run, reference):
    """Returns the worst distance, m, and angle, rad, of two runs."""
    position = max(math.dist(run[key][:3], reference[key][:3]) for key in reference)
    # |q - p| of unit quaternions is 2 sin(angle / 4) for the nearer sign
    apart = max(min(math.dist(run[key][3:], [s * a for a in reference[key][3:]]) for s in (1, -1)) for key in reference)
    return position, 4 * math.asin(min(1.0, apart / 2))


def measure(programs):
    """Returns rows of scene, step, and the errors of each number type."""
    rows = []
    for scene in SCENES:
        reference = poses(programs / "godobject-double", scene, REFERENCE_STEPS)
        for steps, h_ms in STEPS_ms.items():
            found = [errors(poses(programs / f"godobject-{real}", scene, steps), reference) for real in REALS]
            rows.append((scene, h_ms, *(value for pair in found for value in pair)))
    return rows


def draw(csv, png):
    panels = "".join(f"set title '{scene}'\nplot " + ", ".join(
        f"'{csv}' skip 1 using (strcol(1) eq '{scene}' ? $2 : NaN):{3 + 2 * i} with linespoints pt 7 lc rgb '{colour}' title '{real}'"
        for i, (real, colour) in enumerate(zip(REALS, ("#2e7d32", "#fb8c00")))) + "\n" for scene in SCENES)
    script = f"""set terminal pngcairo size 900,320 font 'sans,9'
set output '{png}'
set datafile separator ','
set multiplot layout 1,3
set logscale xy
set grid
set key bottom right
set format y '10^{{%T}}'
set xlabel 'step, ms'
set ylabel 'worst error, m'
{panels}"""
    subprocess.run(["gnuplot"], input=script, text=True, check=True)


def section(rows):
    lines = ["| scene | step, ms | double, m | float, m | double, rad | float, rad |", "|---|---|---|---|---|---|"]
    lines += [f"| {scene} | {h_ms:g} | {d_m:.2g} | {f_m:.2g} | {d_rad:.2g} | {f_rad:.2g} |"
              for scene, h_ms, d_m, d_rad, f_m, f_rad in rows if h_ms in REPORTED_ms]
    return TEXT + "\n".join(lines) + "\n\n![error of float and double](figures/float.png)\n\n"


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    programs, out = map(pathlib.Path, sys.argv[1:3])
    out.mkdir(parents=True, exist_ok=True)
    rows = measure(programs)
    csv = out / "float.csv"
    csv.write_text("scene,step_ms,double_m,double_rad,float_m,float_rad\n"
                   + "".join(f"{row[0]},{','.join(f'{value:.6g}' for value in row[1:])}\n" for row in rows))
    draw(csv, out / "float.png")
    print(re.sub(r"(?s).*?(\| scene.*?)\n\n.*", r"\1", section(rows)))
    if len(sys.argv) == 3:
        return
    report = pathlib.Path(sys.argv[3])
    before, _, after = split(report, "float core")
    report.write_text(before + section(rows) + after)
    shutil.copy(out / "float.png", report.parent / "figures/float.png")


if __name__ == "__main__":
    main()
