#!/usr/bin/env python3
"""Numbers of core that somebody chose stand in core/tuning.h, each with a comment; none is a constant elsewhere.

usage: check_tuning.py SOURCE_DIR
"""
import pathlib
import re
import sys
import tempfile

from verdict import verdict

TUNING = "core/tuning.h"
# What nobody chose, by name: pi; order, d and b of TR-BDF2, 1 - 1/sqrt 2 and sqrt 2 / 4; how many numbers a processor's vector
# holds; how many bodies a spring, a joint and a gear join. Zero, one and minus one are no choices either.
GIVEN = {"core/math/so3.h": {"pi"}, "core/integrator_tr_bdf2.h": {"order", "d", "b"},
         "core/math/simd4.h": {"size", "num_parts"}, "core/term/pair.h": {"max_ends"}, "core/term/term.h": {"max"}}
CONSTANT = re.compile(r"\bconstexpr\s+(?:Real|double|int|std::size_t)\s+([^;]*);")
NAMED = re.compile(r"(\w+)\s*=\s*(?:Real\()?-?(?![01]\b(?!\.))[\d.]+(?:[eE][-+]?\d+)?\)?\s*(?:,|$)")
# A number with a decimal point or an exponent in code, but for halves and quarters.
BARE = re.compile(r"(?<![\w.])(\d+\.\d*(?:[eE][-+]?\d+)?|\d+[eE][-+]?\d+)(?![\w.])")
HALVES = {0.25, 0.5, 1.0, 2.0}
# Files of coefficients; and members of a scene's parameters with what they are where it does not say.
POLYNOMIALS = {"core/math/so3.h", "core/math/rotation_error.h", "core/integrator_tr_bdf2.h"}
DEFAULT = re.compile(r"^\s*Real \w+ = [\d.e+-]+;")


def stray_numbers(source):
    """(number of files read, places of numbers that should stand in core/tuning.h)."""
    read, stray = 0, []
    for path in sorted((source / "core").rglob("*.h")):
        name = str(path.relative_to(source))
        read += 1
        if name == TUNING:
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            code = re.sub(r'"[^"]*"', '""', line.partition("//")[0])
            for constant in CONSTANT.finditer(code):
                stray += [f"{name}:{number}: {of}" for of in NAMED.findall(constant.group(1))
                          if of not in GIVEN.get(name, set())]
            if name in POLYNOMIALS or DEFAULT.match(code):
                continue
            stray += [f"{name}:{number}: {bare}" for bare in BARE.findall(code) if float(bare) not in HALVES]
    return read, stray


def untold_numbers(tuning):
    """Constants of core/tuning.h above which no comment stands."""
    told, untold = False, []
    for line in tuning.splitlines():
        if re.match(r"inline constexpr|struct", line) and not told:
            untold.append(f"{TUNING}: {line.strip()}")
        told = line.startswith("///") or (told and bool(line.strip()) and not line.rstrip().endswith(";"))
    return untold


def finds_stray_ones():
    """The check itself: of these constants it tells those that were chosen, and of two in the table the untold one."""
    with tempfile.TemporaryDirectory() as made:
        source = pathlib.Path(made)
        (source / "core/math").mkdir(parents=True)
        (source / "core/a.h").write_text(
            "inline constexpr Real reach = 0.3;\nstatic constexpr int none = -1, two = 2;\nx = 1e-9 * y;  // 1e-3\n"
            "constexpr Real a = b, c = 4;\nReal h = 1e-3;  // of a scene\nz = 0.5 * x + Real(0.999);\n")
        (source / "core/math/so3.h").write_text("inline constexpr Real pi = 3.14;\n")
        told = stray_numbers(source) == (
            2, ["core/a.h:1: reach", "core/a.h:1: 0.3", "core/a.h:2: two", "core/a.h:3: 1e-9", "core/a.h:4: c", "core/a.h:6: 0.999"])
        return told and untold_numbers("/// m.\ninline constexpr Real a = 1;\ninline constexpr Real b = 2;\n") == [
            f"{TUNING}: inline constexpr Real b = 2;"]


def main(source):
    read, wrong = stray_numbers(source)
    wrong = [f"{place}  -- a choice belongs into {TUNING}" for place in wrong]
    wrong += [f"{place}  -- what does it mean?" for place in untold_numbers((source / TUNING).read_text())]
    return verdict("check_tuning.py", finds_stray_ones(), wrong, read, f"{read} files, all chosen numbers in {TUNING}")


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1])))
