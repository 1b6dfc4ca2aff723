"""Scenes from dicts: TOML text, with the key of each of its lines."""
import functools
import json
import pathlib
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from .errors import Problem, SceneError

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def toml_of(scene: Mapping[str, Any], name: str) -> tuple[str, list[str]]:
    """Returns the text, and for each line the path of its key. name: of the scene in errors."""
    lines: list[str] = []
    keys: list[str] = []
    _write_table(scene, "", "", lines, keys, name)
    return "\n".join(lines) + "\n", keys


@functools.lru_cache(maxsize=10_000)
def _quoted(key: str) -> str:
    return key if _BARE.fullmatch(key) else json.dumps(key)


def _is_table(value: Any) -> bool:
    """True for a dict, or a list of dicts."""
    kind = type(value)
    if kind is dict or kind is float or kind is str:
        return kind is dict
    if kind is list or kind is tuple:
        return len(value) > 0 and type(value[0]) is not float and all(isinstance(one, Mapping) for one in value)
    return isinstance(value, Mapping)


def _write_table(table: Mapping[str, Any], header: str, path: str, lines: list[str], keys: list[str], name: str) -> None:
    """header: of the table in TOML. path: of the table in the dict."""
    tables = []
    prefix = path + "." if path else ""
    for key, value in table.items():
        if not isinstance(key, str):
            raise SceneError([Problem(f"the key {key!r} is not a str", name, key=path)])
        own = prefix + key
        if _is_table(value):
            tables.append((header + "." + _quoted(key) if header else _quoted(key), own, value))
        else:
            lines.append(_quoted(key) + " = " + _value(value, own, name))
            keys.append(own)
    for inner, own, value in tables:
        is_one = isinstance(value, Mapping)
        for i, one in enumerate([value] if is_one else value):
            at = own if is_one else f"{own}[{i}]"
            lines.append(f"[{inner}]" if is_one else f"[[{inner}]]")
            keys.append(at)
            _write_table(one, inner, at, lines, keys, name)


def _value(value: Any, path: str, name: str) -> str:
    kind = type(value)
    if kind is float:  # the usual kinds first, because sweeps write many
        return repr(value)
    if kind is list or kind is tuple:
        return "[" + ", ".join([repr(x) if type(x) is float else _value(x, path, name) for x in value]) + "]"
    if isinstance(value, (str, pathlib.PurePath)):
        return json.dumps(str(value), ensure_ascii=False).replace("\x7f", "\\u007F")
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, np.ndarray):
        return _value(value.tolist(), path, name)
    what = "None: leave the key out" if value is None else f"a {kind.__name__}, which scenes do not have"
    raise SceneError([Problem(f"the value is {what}", name, key=path)])
