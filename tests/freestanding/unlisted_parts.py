#!/usr/bin/env python3
"""Each part that a scene does not list leaves neither a symbol nor an instruction in its step.

    unlisted_parts.py COMPILER SOURCE_DIR EIGEN_DIR

Compiles the steps of unlisted_scene.cc without optimisation and inlining, when all that can be called has a symbol. `nm`
lists the names, the line tables list the headers that code is from. A scene that lists a part has both, otherwise the test
would prove nothing.
"""
import os
import re
import subprocess
import sys
import tempfile

SCENES = ("Bare", "Articulated", "OverObstacles", "AmongBodies", "OfNets", "OfNearlyAll")
# Part: names of its symbols, its headers, and the scenes that list it. Not among the headers: those with types or empty loops
# that other parts share. core/joint/tree.h has the places of bodies; core/system/block_joint.h is not called without joints.
PARTS = {
    "device": (("CouplingInput", "DeviceState", "RampState", "TargetOf"), ("core/device/", "core/body/target.h"),
               ("Articulated", "OverObstacles", "OfNearlyAll")),
    "pose device": (("PoseDevice",), (), ("Articulated",)),
    "relative device": (("RelativeDevice",), (), ("OfNearlyAll",)),
    "admittance device": (("AdmittanceDevice",), (), ("OverObstacles",)),
    "coupling": (("ramped",), (), ("Articulated", "OfNearlyAll")),
    "feedback": (("LimitedFeedback",), ("core/device/feedback.h",), ("Articulated", "OfNearlyAll")),
    "first order": (("ImplicitEuler",), ("core/integrator_implicit_euler.h",), ("Bare", "OverObstacles", "OfNets")),
    "second order": (("TrBdf2",), ("core/integrator_tr_bdf2.h",), ("Articulated", "AmongBodies", "OfNearlyAll")),
    "joints": (("TreeJoints", "JointKind", "JointParams", "JointFrames"),
               ("core/joint/ball.h", "core/joint/cylindrical.h", "core/joint/fixed.h", "core/joint/hinge.h", "core/joint/joint.h",
                "core/joint/list.h", "core/joint/slider.h", "core/joint/stabilisation.h", "core/joint/universal.h",
                "core/joint_stage.h", "core/solve/jointed_bodies.h"), ("Articulated", "OverObstacles", "OfNearlyAll")),
    "stops": (("JointStops",), ("core/joint/stops.h", "core/joint/turns.h"), ("Articulated", "OfNearlyAll")),
    "prescribed joints": (("PrescribedJoints",), ("core/joint/prescribed.h",), ("Articulated", "OfNearlyAll")),
    "contacts": (("NearContact", "ContactFinder", "TouchingBall", "Island"),
                 ("core/contact/", "core/solve/", "core/system/", "core/shape/"),
                 ("OverObstacles", "AmongBodies", "OfNets", "OfNearlyAll")),
    "contacts among bodies": (("BodyContacts",), ("core/contact/find/broad_phase.h",), ("AmongBodies", "OfNets", "OfNearlyAll")),
    "terms": (("TermList", "DampedSprings", "CoordinateSprings", "LoopJoints", "ConstantForces"), ("core/term/",), ("OfNearlyAll",)),
    "nets": (("MassSpringNet", "NetStage", "NodeGroup"), ("core/net/", "core/net_", "core/solve/net", "core/body/node.h"),
             ("OfNets", "OfNearlyAll")),
    "attachments of nets": (("NetAttachment",), (), ("OfNearlyAll",)),
    "faces of nets": (("NetFace", "NetPatch"), ("core/net/find_faces.h", "core/net/face_contacts.h"), ("OfNets",)),
}


def output_of(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def compile_steps(compiler, source, eigen, folder):
    """Compiles the step of each scene to <scene>.o in a folder."""
    command = [compiler, "-std=c++20", "-O0", "-fno-inline", "-g1", "-DGODOBJECT_NO_FLATTEN", "-DEIGEN_DONT_VECTORIZE",
               "-I", source, "-isystem", eigen]
    header = os.path.join(folder, "core.h")
    with open(header, "w", encoding="utf-8") as file:
        file.write('#include "core/godobject.h"\n')
    subprocess.run([*command, "-x", "c++-header", header, "-o", header + ".gch"], check=True)  # it takes half the time
    for scene in SCENES:
        subprocess.run([*command, "-include", header, "-x", "c++", "-c", "-o", os.path.join(folder, scene + ".o"), "-"], check=True,
                       text=True, input=f'#define PROBED {scene}\n#include "tests/freestanding/unlisted_scene.cc"\n')


def headers_with_code(source, table):
    """Headers, from the source directory, in a decoded line table."""
    headers, file = set(), ""
    for line in table.splitlines():
        if line.endswith(":"):  # the file that the rows below it are of
            file = os.path.normpath(os.path.join(source, line.removeprefix("CU: ").rstrip(":[+]")))
        elif re.match(r"\S+\.h\s+\d+\s+0", line):
            headers.add(os.path.relpath(file, source))
    return headers


def in_symbols(name, symbols):
    """The first mangled symbol with this name of a type or function; None if there is none. Names there follow their length."""
    at = symbols.find(f"{len(name)}{name}")
    return None if at < 0 else symbols[symbols.rfind("\n", 0, at) + 1:symbols.find("\n", at)].split()[-1]


def complaints(symbols, headers):
    """Parts with a trace in a scene that does not list them, and without one in a scene that does. Arguments: by scene."""
    found = []
    for part, (names, folders, listing) in PARTS.items():
        for scene in SCENES:
            of_names = [symbol for symbol in (in_symbols(name, symbols[scene]) for name in names) if symbol]
            of_headers = sorted(header for header in headers[scene] if folders and header.startswith(folders))
            if scene not in listing:
                found += [f"{scene} does not list {part}, and has {trace}" for trace in (*of_names, *of_headers)]
            elif not of_names or (folders and not of_headers):
                found.append(f"{scene} lists {part}, and has no symbol or no line of it: this says nothing")
    return found


def check_rules():
    """The rules must refuse a symbol and a header of each part in a scene without it, and their absence in one with it."""
    symbol = {part: f"0000 W _ZN9godobject{len(names[0])}{names[0]}Ev\n" for part, (names, _, _) in PARTS.items()}
    symbols = {scene: "".join(symbol[part] for part in PARTS if scene in PARTS[part][2]) for scene in SCENES}
    headers = {scene: {folders[0] for _, folders, listing in PARTS.values() if folders and scene in listing} for scene in SCENES}
    assert not complaints(symbols, headers), complaints(symbols, headers)
    for part, (_, folders, listing) in PARTS.items():
        for scene in SCENES:
            if scene not in listing:
                assert complaints(symbols | {scene: symbols[scene] + symbol[part]}, headers), (part, scene)
                assert not folders or complaints(symbols, headers | {scene: headers[scene] | {folders[0]}}), (part, scene)
            else:
                assert complaints(symbols | {scene: ""}, headers), (part, scene)
        assert set(listing) < set(SCENES), f"{part}: no scene without it"


def main(compiler, source, eigen):
    check_rules()
    with tempfile.TemporaryDirectory() as folder:
        compile_steps(compiler, source, eigen, folder)
        objects = {scene: os.path.join(folder, scene + ".o") for scene in SCENES}
        symbols = {scene: output_of("nm", "--defined-only", path) for scene, path in objects.items()}
        headers = {scene: headers_with_code(source, output_of("objdump", "--dwarf=decodedline", path))
                   for scene, path in objects.items()}
    found = complaints(symbols, headers)
    if found:
        print(subprocess.run(["c++filt"], input="\n".join(found), check=True, text=True, capture_output=True).stdout)
    print(f"{len(PARTS)} parts in {len(SCENES)} scenes, {len(found)} complaints")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
