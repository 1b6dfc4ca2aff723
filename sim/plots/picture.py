#!/usr/bin/env python3
"""Draws the boxes of a scene at one time of a trace: SVG on standard output.

usage: picture.py SCENE.toml TRACE.csv TIME_S > picture.svg

Bodies are solid; bodies coupled to the device are red, their targets wireframes.
"""
import csv
import math
import sys
import tomllib

WIDTH, HEIGHT = 900, 340
EYE_AZIMUTH, EYE_ELEVATION = math.radians(-62), math.radians(34)
FACES = [(0, -1), (0, 1), (1, -1), (1, 1), (2, -1), (2, 1)]  # axis, side


def turned(q, v):
    w, x, y, z = q
    t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])]
    return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2],
            v[2] + w * t[2] + x * t[1] - y * t[0]]


def seen(p):
    """Coordinates to the right, up and towards the eye."""
    ca, sa, ce, se = math.cos(EYE_AZIMUTH), math.sin(EYE_AZIMUTH), math.cos(EYE_ELEVATION), math.sin(EYE_ELEVATION)
    ahead = ca * p[0] + sa * p[1]
    return [-sa * p[0] + ca * p[1], -se * ahead + ce * p[2], ce * ahead + se * p[2]]


def face(pose, half, axis, side):
    p, q = pose
    u, v = (axis + 1) % 3, (axis + 2) % 3
    corners = []
    for a, b in [(-1, -1), (1, -1), (1, 1), (-1, 1)]:
        c = [0.0, 0.0, 0.0]
        c[axis], c[u], c[v] = side * half[axis], a * half[u], b * half[v]
        corners.append([x + y for x, y in zip(p, turned(q, c))])
    n = [0.0, 0.0, 0.0]
    n[axis] = float(side)
    return corners, turned(q, n)


def boxes(scene):
    """Half extents by body; a body with `like` has the shapes of the other body."""
    found, bodies = {}, {body["name"]: body for body in scene["body"]}
    for name, body in bodies.items():
        shapes = body.get("shape") or bodies.get(body.get("like"), {}).get("shape") or []
        half = [shape["half_extents"] for shape in shapes if shape["kind"] == "box"]
        if half:
            found[name] = half[0]
    return found


def pose_in(row, prefix):
    return ([float(row[f"{prefix}.{c}"]) for c in "xyz"], [float(row[f"{prefix}.q{c}"]) for c in "wxyz"])


def main():
    scene_path, trace_path, time = sys.argv[1], sys.argv[2], float(sys.argv[3])
    with open(scene_path, "rb") as file:
        half_of = boxes(tomllib.load(file))
    with open(trace_path, newline="", encoding="utf-8") as file:
        row = min(csv.DictReader(file), key=lambda r: abs(float(r["t"]) - time))
    solids, wires = [], []
    names = [column.removesuffix(".qw") for column in row if column.endswith(".qw") and ".target" not in column]
    for number, name in enumerate(names):
        if name not in half_of:
            continue
        half, pose = half_of[name], pose_in(row, name)
        held = row.get("held", "") == str(number) if "held" in row else f"{name}.target.x" in row
        for axis, side in FACES:
            corners, n = face(pose, half, axis, side)
            if seen(n)[2] > 0:
                solids.append((sum(seen(c)[2] for c in corners), corners, n, held))
            if held:
                wires.append(face(pose_in(row, f"{name}.target"), half, axis, side)[0])
    points = [seen(c) for _, corners, _, _ in solids for c in corners]
    left, right = min(p[0] for p in points), max(p[0] for p in points)
    low, high = min(p[1] for p in points), max(p[1] for p in points)
    scale = 0.92 * min(WIDTH / (right - left), HEIGHT / (high - low))

    def drawn(corners):
        return " ".join(f"{WIDTH / 2 + scale * (p[0] - (left + right) / 2):.1f},"
                        f"{HEIGHT / 2 - scale * (p[1] - (low + high) / 2):.1f}" for p in map(seen, corners))

    print(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}">')
    print(f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#f7f8fa"/>')
    for _, corners, n, held in sorted(solids, key=lambda s: s[0]):
        light = 0.55 + 0.45 * max(0, 0.3 * n[0] - 0.4 * n[1] + 0.87 * n[2])
        colour = [int(light * c) for c in ((224, 82, 60) if held else (126, 160, 200))]
        print(f'<polygon points="{drawn(corners)}" fill="rgb{tuple(colour)}" stroke="#234" stroke-width="0.6"/>')
    for corners in wires:
        print(f'<polygon points="{drawn(corners)}" fill="none" stroke="#c00" stroke-width="1.4" stroke-dasharray="4 2"/>')
    print("</svg>")


if __name__ == "__main__":
    main()
