"""The suite of godobject itself: fixtures of godobject.hil, from the source tree; see README.md."""
import os
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "platform" / "python"))

pytest_plugins = ["godobject.hil.pytest_plugin"]


def pytest_addoption(parser):
    parser.addoption("--looping", help="godobject_looping, for the endless loop of test_torque_gone.py")
    parser.addoption("--torque-gone", help="file to which test_torque_gone.py adds its times")


@pytest.hookimpl(trylast=True)  # after -k has selected
def pytest_collection_modifyitems(items):
    """Every k-th test where k, GTEST_TOTAL_SHARDS, is in the environment, as in `./dev test`."""
    items[:] = items[::int(os.environ.get("GTEST_TOTAL_SHARDS", "1"))]
