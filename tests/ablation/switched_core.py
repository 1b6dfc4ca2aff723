#!/usr/bin/env python3
"""Copies core into a folder so that each number of core/tuning.h and each mechanism can be switched at run time.

usage: switched_core.py SOURCE_DIR    checks that core has the text of every mechanism, once

GODOBJECT_ABLATION in the environment selects the change: "<number>=<value>" or "<mechanism>". Without it, the copy
computes the same as core.
"""
import pathlib
import re
import shutil
import sys
import tempfile

from mechanisms import MECHANISMS

# Sizes of arrays: a smaller one is a capacity of another program, not another algorithm.
SIZES = {"blocks_per_body", "net_pairs_per_body", "max_touched_faces", "max_materials", "max_wound_axes",
         "max_faces_of_node", "max_face_candidates", "gain_steps"}
SWITCH = """#pragma once
#include <cstdlib>
#include <cstring>
namespace godobject::ablation {
inline const char* selected() noexcept {
  const char* const text = std::getenv("GODOBJECT_ABLATION");
  return text ? text : "";
}
inline double number(const char* name, double value) noexcept {
  const char* const text = selected();
  const std::size_t length = std::strlen(name);
  return std::strncmp(text, name, length) == 0 && text[length] == '=' ? std::atof(text + length + 1) : value;
}
inline bool is_off(const char* name) noexcept { return std::strcmp(selected(), name) == 0; }
}  // namespace godobject::ablation
#define GODOBJECT_OFF(name) ([]() noexcept { static const bool is = godobject::ablation::is_off(name); return is; }())
"""
LIST = re.compile(r"^(inline|  static) constexpr (Real|int|std::size_t|std::uint32_t)\s+(\w+ = [^;(]*);", re.M)
TOLERANCE = re.compile(r"static constexpr Real (\w+_tolerance)\((int[ \w]*)\) noexcept \{\s*return ([^;]*);")


def switched_tuning(text):
    """(text with numbers read from the environment, {number: its value})."""
    numbers, scope = {}, ""

    def replaced(match):
        begin, kind, names = match.groups()
        owner = re.findall(r"^struct (\w+)", text[:match.start()], re.M)
        scope = f"{owner[-1]}." if begin != "inline" else ""
        parts, kept = [], []
        for one in names.replace("\n", " ").split(","):
            name, value = (side.strip() for side in one.split(" = "))
            if name in SIZES or kind == "bool":
                kept.append(f"{name} = {value}")
                continue
            numbers[scope + name] = value
            parts.append(f'{name} = static_cast<{kind}>(ablation::number("{scope + name}", {value}))')
        inline = "inline" if begin == "inline" else "  static inline"
        return "\n".join([f"{begin} constexpr {kind} {', '.join(kept)};"] * bool(kept) +
                         [f"{inline} const {kind} {', '.join(parts)};"] * bool(parts))

    def scaled(match):
        name, argument, value = match.groups()
        owner = re.findall(r"^struct (\w+)", text[:match.start()], re.M)[-1]
        if value.endswith("(iteration)"):
            return match.group(0)
        numbers[f"{owner}.{name}"] = "1"
        return (f'static Real {name}({argument}) noexcept {{\n    static const Real share = '
                f'ablation::number("{owner}.{name}", 1);\n    return share * ({value});')

    text = LIST.sub(replaced, text)
    text = TOLERANCE.sub(scaled, text)
    text = text.replace("static constexpr Real friction_tolerance(int iteration) noexcept { return normal",
                        "static Real friction_tolerance(int iteration) noexcept { return normal")
    return text.replace("#pragma once\n", '#pragma once\n#include "core/ablation.h"\n', 1), numbers


def switched_mechanisms(out):
    """Switches each mechanism in the copied files. Raises if a text does not occur once."""
    for name, _, file, old, new in MECHANISMS:
        path = out / file
        text = path.read_text()
        if text.count(old) != 1:
            raise SystemExit(f"ablate: '{name}': {text.count(old)} times in {file}: {old}")
        text = text.replace(old, re.sub(r"\bOFF\b", f'GODOBJECT_OFF("{name}")', new))
        if "core/ablation.h" not in text:
            text = text.replace("#pragma once\n", '#pragma once\n#include "core/ablation.h"\n', 1)
        path.write_text(text)


def copy(source, out):
    """Writes the copy below `out`, only files that changed. Returns {number: its value}."""
    fresh = out / "fresh"
    shutil.rmtree(fresh, ignore_errors=True)
    shutil.copytree(source / "core", fresh / "core")
    (fresh / "core/ablation.h").write_text(SWITCH)
    tuning, numbers = switched_tuning((fresh / "core/tuning.h").read_text())
    (fresh / "core/tuning.h").write_text(tuning)
    names = "|".join(sorted({name.rpartition(".")[2] for name in numbers}, key=len, reverse=True))
    used = re.compile(rf"\bconstexpr (Real|int|std::size_t|std::uint32_t) (\w+ =[^;]*\b(?:{names})\b[^;]*;)")
    for path in (fresh / "core").rglob("*.h"):
        text = path.read_text()
        if path.name != "tuning.h" and used.search(text):
            path.write_text(used.sub(r"const \1 \2", text))
    switched_mechanisms(fresh)
    for path in fresh.rglob("*"):
        to = out / path.relative_to(fresh)
        if path.is_dir():
            to.mkdir(parents=True, exist_ok=True)
        elif not to.exists() or to.read_bytes() != path.read_bytes():
            to.write_bytes(path.read_bytes())
    shutil.rmtree(fresh)
    return numbers


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        print(f"{len(MECHANISMS)} mechanisms, {len(copy(pathlib.Path(sys.argv[1]), pathlib.Path(folder)))} numbers")
