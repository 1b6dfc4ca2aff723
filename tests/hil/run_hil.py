"""Runs the suite with pytest and passes its options on; exits with 77 and the reason if a package is missing."""
import importlib.util
import sys
from pathlib import Path

PACKAGES = {"pytest": "python3-pytest"}

missing = [debian for module, debian in PACKAGES.items() if importlib.util.find_spec(module) is None]
if missing:
    print(f"skipped: {sys.executable} has no {', '.join(missing)}: apt-get install {' '.join(missing)}")
    sys.exit(77)

import pytest

sys.dont_write_bytecode = True
sys.exit(pytest.main(["-q", "-p", "no:cacheprovider", str(Path(__file__).parent), *sys.argv[1:]]))
