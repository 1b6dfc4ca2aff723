#!/usr/bin/env python3
"""No instruction of a scene comes from contacts or nets it does not have.

    unlisted_parts.py COMPILER SOURCE_DIR EIGEN_DIR

Compiles the step of four scenes without optimisation, when all that can be called has code, and asks the line tables
which headers of the core that code is from. A scene whose bodies touch each other shows that the tables tell.
"""
import os
import re
import subprocess
import sys
import tempfile

# Of contacts between bodies alone. Edges of a tool's boxes also meet the boxes of the world.
BODIES = {"core/contact/find/broad_phase.h"}
CONTACTS = ("core/contact/", "core/solve/", "core/system/", "core/shape/")
NETS = ("core/net/", "core/solve/net")


def headers_with_code(compiler, source, eigen, scene, folder):
    """Headers, from the source directory, that the object code of the scene's step is from."""
    obj = os.path.join(folder, scene + ".o")
    subprocess.run([compiler, "-std=c++20", "-O0", "-g1", "-DGODOBJECT_NO_FLATTEN", "-DEIGEN_DONT_VECTORIZE",
                    "-DPROBED=" + scene, "-I", source, "-isystem", eigen,
                    "-c", os.path.join(source, "tests/core/contact/unlisted_scene.cc"), "-o", obj], check=True)
    lines = subprocess.run(["objdump", "--dwarf=decodedline", obj], check=True, capture_output=True, text=True)
    headers, file = set(), ""
    for line in lines.stdout.splitlines():
        if line.endswith(":"):  # the file that the rows below it are of
            file = os.path.normpath(os.path.join(source, line.removeprefix("CU: ").rstrip(":[+]")))
        elif re.match(r"\S+\.h\s+\d+\s+0", line):
            headers.add(os.path.relpath(file, source))
    return headers


def within(folders, names):
    return {name for name in names if name.startswith(folders)}


def main(compiler, source, eigen):
    with tempfile.TemporaryDirectory() as folder:
        untouched, over_obstacles, among_bodies, with_net = (
            headers_with_code(compiler, source, eigen, scene, folder)
            for scene in ("Untouched", "OverObstacles", "AmongBodies", "OfANet"))
    if not ("core/step.h" in untouched and "core/solve/bodies.h" in over_obstacles and
            BODIES <= among_bodies and "core/solve/nets.h" in with_net):
        sys.exit("the line tables do not show code that is there: this says nothing")
    for scene, strange in (("without contacts", within(CONTACTS + NETS, untouched)),
                          ("over obstacles alone", (BODIES & over_obstacles) | within(NETS, over_obstacles)),
                          ("among bodies", within(NETS, among_bodies))):
        if strange:
            sys.exit(f"a scene {scene} has code from {' '.join(sorted(strange))}")


if __name__ == "__main__":
    main(*sys.argv[1:])
