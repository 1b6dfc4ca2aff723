import os
import subprocess

import pytest


@pytest.fixture
def run(tmp_path):
    """Runs `godobject run SCENE --fast` and returns the report. Options with {} are paths in the test's folder."""
    from godobject import read_report

    def run_scene(scene, *options):
        words = [option.format(tmp_path) for option in options]
        done = subprocess.run([os.environ["GODOBJECT_PROGRAM"], "run", scene, "--fast", "--quiet", "--report",
                               f"{tmp_path}/report.json", *words], capture_output=True, text=True, timeout=60)
        assert done.returncode in (0, 1), done.stderr
        return read_report(tmp_path / "report.json")

    return run_scene
