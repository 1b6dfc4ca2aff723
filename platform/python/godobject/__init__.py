"""Python of godobject.

- `Scene`: the session of `godobject run` as arrays (docs/how-to/python.md)
- `read_trace`, `read_contacts`, `read_recording`, `read_report`: files of `godobject run` as arrays
- `godobject.device`: a program of your own as the device of a run
- `godobject.world`: a slow simulation of your own around the tool of a run
- `godobject.hil`: hardware-in-the-loop tests

`godobject.device` and `godobject.hil` need the standard library alone, the others numpy, `Scene` the compiled module.
"""
import importlib
import pathlib
import pkgutil
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    # "as": mypy --strict then lets programs of users import these names.
    from .errors import FaultError as FaultError, InputError as InputError, MotionError as MotionError, Problem as Problem
    from .errors import ReadError as ReadError, SceneError as SceneError, SceneWarning as SceneWarning
    from .readers import Report as Report, Trace as Trace, read_contacts as read_contacts
    from .readers import read_recording as read_recording, read_report as read_report, read_trace as read_trace
    from .scene import Contacts as Contacts, Rows as Rows, Scene as Scene

# The compiled module: beside this file if installed, else of a build directory in PYTHONPATH, or of build/release.
__path__ = pkgutil.extend_path(__path__, __name__)
_build = pathlib.Path(__file__).parents[3] / "build/release/platform/python/godobject"
if _build.is_dir() and str(_build) not in __path__:
    __path__.append(str(_build))

_MODULES = {
    "errors": ("FaultError", "InputError", "MotionError", "Problem", "ReadError", "SceneError", "SceneWarning"),
    "readers": ("Report", "Trace", "read_contacts", "read_recording", "read_report", "read_trace"),
    "scene": ("Contacts", "Rows", "Scene"),
}
__all__ = [name for names in _MODULES.values() for name in names]


def __getattr__(name: str) -> Any:
    """Imports numpy and the compiled module where a name needs them, because godobject.hil does without."""
    for module, names in _MODULES.items():
        if name in names:
            return getattr(importlib.import_module("." + module, __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
