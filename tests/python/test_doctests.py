"""The examples of the docstrings, and the module without its compiled part."""
import doctest
import importlib
import subprocess
import sys

import pytest


@pytest.mark.parametrize("name", ["scene", "readers", "errors", "device"])
def test_doctests(name):
    module = importlib.import_module("godobject." + name)
    result = doctest.testmod(module, optionflags=doctest.ELLIPSIS)
    assert result.failed == 0
    if name in ("scene", "readers"):
        assert result.attempted > 0


def test_stubs_have_all_names_of_the_module():
    import ast
    from pathlib import Path

    import godobject._core as core
    from godobject import scene
    stub = Path(scene.__file__).with_name("_core.pyi")
    session = next(node for node in ast.parse(stub.read_text()).body if isinstance(node, ast.ClassDef))
    stubbed = {node.name for node in session.body if isinstance(node, ast.FunctionDef)} - {"__init__"}
    real = {name for name in vars(core.Session) if not name.startswith("__") and name != "_pybind11_conduit_v1_"}
    assert stubbed == real
    functions = {node.name for node in ast.parse(stub.read_text()).body if isinstance(node, ast.FunctionDef)}
    assert functions == {name for name, value in vars(core).items() if callable(value) and not isinstance(value, type)}
    assert stub.with_name("py.typed").exists()


def test_hil_needs_neither_numpy_nor_the_compiled_module(tmp_path):
    code = ("import sys; sys.modules['numpy'] = None; sys.modules['godobject._core'] = None\n"
            "import godobject; from godobject import hil, device\n"
            "try: godobject.Scene\n"
            "except ImportError as error: print(error)\n")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "numpy" in done.stdout


def test_a_missing_module_is_explained():
    code = "import sys; sys.modules['godobject._core'] = None\nfrom godobject import read_trace\nimport godobject.scene\n"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 1
    assert "ImportError: godobject has no compiled module: install pybind11-dev" in done.stderr
