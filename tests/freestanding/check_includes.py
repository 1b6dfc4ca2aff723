#!/usr/bin/env python3
"""Checks who includes whom: core <- hal <- sim <- platform, and no product includes tests. Of platform only the rooms that
simulate see sim and each other; the rest builds without them. The folders of each layer include each other in one direction.

usage: check_includes.py SOURCE_DIR
"""
import pathlib
import re
import sys

# Headers of the core that need neither an OS nor a heap; immintrin.h is the compiler's.
CORE_STD = {"algorithm", "array", "bit", "cmath", "compare", "concepts", "cstddef", "cstdint",
            "immintrin.h", "initializer_list", "limits", "numbers", "optional", "span", "tuple", "type_traits", "utility"}
# What hal must not include: the operating system, threads, streams, clocks, exceptions.
HAL_REFUSED = {"atomic", "chrono", "condition_variable", "exception", "filesystem", "fstream", "future",
               "iostream", "mutex", "shared_mutex", "stdexcept", "stop_token", "thread"}
LAYERS = {"core", "hal", "sim", "platform", "tests"}
MAY_INCLUDE = {"core": {"core"}, "hal": {"core", "hal"}, "sim": {"core", "hal", "sim"},
               "platform": {"core", "hal", "platform"}}
# Files directly in a layer's folder are its top room: core/step.h is of "core" and includes the rooms of its parts. These files of
# core have no part of a scene in them, and every room includes them. They count with core/math, the lowest room.
FLOOR = {"core/composition.h": "core/math", "core/fault.h": "core/math", "core/tuning.h": "core/math"}
SIMULATE = {("platform", "simulated"), ("platform", "cli", "simulate"), ("platform", "python")}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')


def complaint(folder, header):
    """Why a file of `folder` (of the source tree) may not include `header`; None if it may."""
    layer = folder.parts[0]
    target = header.split("/")[0]
    if target in LAYERS and "/" in header:
        simulates = folder.parts[:2] in SIMULATE or folder.parts[:3] in SIMULATE
        room = pathlib.PurePath(header).parts
        if layer == "platform" and not simulates and (room[:2] in SIMULATE or room[:3] in SIMULATE):
            return "what runs without simulation may not include what simulates"
        allowed = MAY_INCLUDE[layer] | ({"sim"} if layer == "platform" and simulates else set())
        return None if target in allowed else f"{layer} may include {', '.join(sorted(allowed))}"
    if layer == "core" and target != "Eigen" and header not in CORE_STD:
        return "core includes Eigen and headers that need no OS and no heap"
    if layer == "hal" and (header in HAL_REFUSED or re.match(r"(sys|linux|net)/|[a-z_]+\.h$", header)):
        return "hal knows no OS, thread, clock or stream"
    return None


def room_of(path):
    """The first two folders of a file's path: "platform/rig"; of a file of FLOOR the room that it counts with."""
    return FLOOR.get(str(path)) or "/".join(pathlib.PurePath(path).parts[:-1][:2])


def reached(room, arrows, seen=None):
    """The rooms that `room` includes, directly or by others. arrows: room -> rooms that it includes."""
    seen = set() if seen is None else seen
    for other in arrows.get(room, set()) - seen:
        seen.add(other)
        reached(other, arrows, seen)
    return seen


def circles(arrows):
    """Complaints about rooms that include each other, directly or by others."""
    return [f"{a} and {b} include each other" for a in sorted(arrows) for b in sorted(arrows[a]) if a < b and a in reached(b, arrows)]


def complaints(source_dir):
    found, num_files = [], 0
    arrows = {}
    for layer in MAY_INCLUDE:
        for path in sorted((source_dir / layer).rglob("*")):
            if path.suffix not in {".h", ".cc"}:
                continue
            num_files += 1
            relative = path.relative_to(source_dir)
            for number, line in enumerate(path.read_text().splitlines(), 1):
                match = INCLUDE.match(line)
                reason = match and complaint(relative.parent, match.group(1))
                if reason:
                    found.append(f"{relative}:{number}: includes {match.group(1)}: {reason}")
                if match and match.group(1).startswith(layer + "/"):
                    room, other = room_of(relative), room_of(match.group(1))
                    if room != other:
                        arrows.setdefault(room, set()).add(other)
    found += circles(arrows)
    return found, num_files


def check_rules():
    """The rules themselves: they must refuse."""
    path = pathlib.PurePath
    for folder, header in [("core", "vector"), ("core", "hal/can/bus.h"), ("hal", "platform/motion/motion.h"),
                           ("hal", "thread"), ("hal", "unistd.h"), ("hal", "sim/hand.h"),
                           ("sim", "platform/rt/cyclic.h"), ("sim", "tests/oracle/case/case.h"),
                           ("platform", "tests/study/study.h"), ("platform/session", "sim/rig/rig.h"),
                           ("platform/cli", "sim/rig/rig.h"), ("platform/session", "platform/simulated/session.h"),
                           ("platform/cli", "platform/cli/simulate/simulation.h")]:
        assert complaint(path(folder), header), (folder, header)
    for folder, header in [("core", "core/math/so3.h"), ("core", "Eigen/Core"), ("hal", "core/math/types.h"),
                           ("hal", "vector"), ("sim", "hal/can/bus.h"), ("platform/scene", "hal/rig/simulation.h"),
                           ("platform/simulated", "sim/rig/rig.h"), ("platform/cli/simulate", "sim/rig/rig.h"),
                           ("platform/cli", "platform/motion/motion.h"), ("platform", "sys/mman.h")]:
        assert not complaint(path(folder), header), (folder, header)
    assert circles({"a": {"b"}, "b": {"c"}, "c": {"a"}}) and not circles({"a": {"b", "c"}, "b": {"c"}})
    assert circles({"a": {"b"}, "b": {"a"}}) == ["a and b include each other"]
    assert room_of("core/step.h") == "core" and room_of("core/tuning.h") == "core/math"
    assert room_of("platform/scene/net/params.h") == "platform/scene" and room_of("sim/hand.h") == "sim"


def main():
    check_rules()
    found, num_files = complaints(pathlib.Path(sys.argv[1]))
    print("\n".join(found))
    print(f"{num_files} files, {len(found)} refused includes")
    return 1 if found or num_files == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
