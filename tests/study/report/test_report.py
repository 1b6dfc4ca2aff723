#!/usr/bin/env python3
"""Tests of the scripts that compose the report's head, its section of steps and the README's table.

usage: test_report.py REPORT
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from head import Report, times_text
from readme import Steps, time_text

HERE = pathlib.Path(__file__).parent
NOTICEABLE = 0.95  # of our value, from which on another engine is better


def with_rows(text, heading, rows):
    """Returns the text with rows added at the end of the table whose head begins so."""
    lines = text.splitlines()
    at = next(i for i, line in enumerate(lines) if line.startswith(heading))
    while lines[at].startswith("|"):
        at += 1
    return "\n".join([*lines[:at], *rows, *lines[at:]]) + "\n"


class Head(unittest.TestCase):
    def test_first_line_names_each_scene_that_the_tables_lose(self):
        report = Report(TEXT)
        lost = set()
        for i, scene in enumerate(("S1", "S3", "S5")):
            for column in (1 + 3 * i, 2 + 3 * i):
                errors = {row[0]: float(row[column]) for row in report.peers if row[column] not in ("-", "fails")}
                others = [error for engine, error in errors.items() if not engine.startswith(("implicit-euler", "tr-bdf2"))]
                lost |= {scene} if min(others) < NOTICEABLE * errors["tr-bdf2"] else set()
        for scene, rows in (("S4", report.bricks), ("S6", report.nets)):
            ours = min(float(row[1]) for row in rows if row[0].startswith(("implicit-euler", "tr-bdf2")))
            others = [float(row[1]) for row in rows if not row[0].startswith(("implicit-euler", "tr-bdf2")) and row[1] != "fails"]
            lost |= {scene} if min(others) < NOTICEABLE * ours else set()
        for scene, ours, *ratios in report.work:
            bounded = [float(re.match(r"[<>]? ?([\d.e+-]+)", r).group(1)) for r in ratios if re.match(r"<? ?\d", r)]
            lost |= {scene} if any(ratio < NOTICEABLE for ratio in bounded) else set()
        self.assertTrue(lost)
        self.assertEqual({scene for scene in lost if scene not in report.first_line()}, set())

    def test_first_line_names_losses_of_each_integrator(self):
        lines = ("\n- than tr-bdf2: S2 penetration at 1 N/m (Bullet 3.24 10 it: 1, ours 2).\n"
                 "- than implicit-euler: S6 stretch (MuJoCo 2.2 springs: 1, ours 2).\n"
                 "- in equal native time or to an equal error: S5 than implicit-euler (ODE 0.16 rows, its time: 0.8 times ours).\n")
        report = Report.__new__(Report)
        report.text = lines
        self.assertEqual(report.first_line(), "**Other engines are better**, by 5 % or more: than tr-bdf2 at a step of 1 ms Bullet 3.24 (S2). "
                         "Also than implicit-euler at a step of 1 ms MuJoCo 2.2 (S6); in equal native time or to an equal error ODE 0.16 (S5).")
        report.text = "No peer is better than ours by 5 % at a step of 1 ms.\n"
        self.assertEqual(report.first_line(), "No other engine is better than ours, by 5 % or more.")

    def test_bounds_stay_bounds(self):
        self.assertEqual(times_text("6.3e+02 (Bullet 3.24 50 it)"), ("630 times", "Bullet 3.24 50 it"))
        self.assertEqual(times_text("> 1.8 (A (b))"), ("at least 1.8 times", "A (b)"))


class Readme(unittest.TestCase):
    def test_engines_have_their_fastest_native_setting(self):
        text = with_rows(TEXT, "| engine | S4, m |", ["| MuJoCo 2.2 slow | 0.1 | 0.1 | 9999 |", "| MuJoCo 2.2 fast | 0.1 | 0.1 | 12.3 |",
                                                      "| MuJoCo 2.2 other | 0.1 | 0.1 | 1 W |"])
        times = dict(Steps(Report(text)).all())["64 bricks, S4"]
        self.assertEqual(times[2], 12.3)
        self.assertIsNone(times[1])

    def test_times_have_a_unit(self):
        self.assertEqual([time_text(us) for us in (0.0791, 5.0, 178, 1227)], ["0.079 us", "5 us", "178 us", "1.2 ms"])


class Benchmarks(unittest.TestCase):
    def written(self, names):
        """Returns the result of steps.py and the report that it wrote, from benchmarks of 1000, 2000, ... ns."""
        with tempfile.TemporaryDirectory() as folder:
            bench, report = pathlib.Path(folder) / "bench.json", pathlib.Path(folder) / "report.md"
            bench.write_text(json.dumps({"benchmarks": [{"run_name": f"{name}/min_time:0.100/repeats:9", "aggregate_name": "median",
                                                         "p50_ns": 1000 * (i + 1)} for i, name in enumerate(names)]}))
            report.write_text("before\n<!-- begin of the steps -->\nold\n<!-- end of the steps -->\nafter\n")
            done = subprocess.run([sys.executable, "-B", HERE / "steps.py", bench, report], capture_output=True, text=True)
            return done, report.read_text()

    def test_section_has_our_steps_and_the_fastest_of_others(self):
        ours = [f"{step} {integrator}" for step in ("S1/haptic-1", "S5/free-joints-64") for integrator in ("implicit-euler", "tr-bdf2")]
        done, text = self.written([*ours, "S5/64/Bullet 3.24 a", "S5/64/Bullet 3.24 b", "S5/256/ODE 0.16 a"])
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("\n| rigid tool with feedback, S1 | 1 | 2 | - | - | - |\n| 64 links on ball joints, S5 | 3 | 4 | - | 5 | - |\n", text)
        self.assertTrue(text.startswith("before\n") and text.endswith("after\n") and "old" not in text)

    def test_results_of_a_filter_are_refused(self):
        done, text = self.written(["S1/haptic-1 implicit-euler", "S1/haptic-1 tr-bdf2"])
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("has no 'S5/free-joints-64 implicit-euler': run ./dev bench --page without a filter", done.stderr)
        self.assertIn("old", text)


if __name__ == "__main__":
    TEXT = pathlib.Path(sys.argv.pop(1)).read_text()
    unittest.main()
