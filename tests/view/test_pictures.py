#!/usr/bin/env python3
"""Pictures without a browser: contents of the files; the device is visible apart from the tool while that is
pressed on the wall.

usage: test_pictures.py --program PATH
"""
import base64
import json
import os
import struct
import subprocess
import tempfile
import time
import zlib

from viewed_run import SOURCE, arguments

ARGS = arguments()
TOOL, GHOST, WALL = (0xD5, 0x45, 0x2C), (0xE0, 0x8A, 0x1E), (0xA9, 0xA2, 0x94)


def godobject(*args, code=0):
    result = subprocess.run([ARGS.program, *args], cwd=SOURCE, capture_output=True, text=True, timeout=120, check=False)
    assert result.returncode == code, (args, result.returncode, result.stderr)
    return result.stderr


def chunks(data):
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at = 8
    while at < len(data):
        size, = struct.unpack_from(">I", data, at)
        kind, body = data[at + 4:at + 8], data[at + 8:at + 8 + size]
        assert zlib.crc32(kind + body) == struct.unpack_from(">I", data, at + 8 + size)[0], kind
        yield kind, body
        at += 12 + size


def image(path):
    """Returns the rows of pixels and the number of frames."""
    with open(path, "rb") as file:
        parts = list(chunks(file.read()))
    width, height = struct.unpack_from(">II", parts[0][1])
    raw = zlib.decompress(b"".join(body for kind, body in parts if kind == b"IDAT"))
    stride, rows, above = 3 * width, [], bytes(3 * width)
    assert len(raw) == (stride + 1) * height
    for y in range(height):
        line = raw[y * (stride + 1):(y + 1) * (stride + 1)]
        assert line[0] == 2
        above = bytes((a + b) & 255 for a, b in zip(line[1:], above))
        rows.append([tuple(above[x:x + 3]) for x in range(0, stride, 3)])
    for kind, body in parts:
        if kind == b"fdAT":
            assert len(zlib.decompress(body[4:])) == len(raw)
    return rows, sum(kind == b"fcTL" for kind, _ in parts)


def like(pixel, colour, shade=0.45):
    """True if the channels have the colour's ratio, in any light."""
    light = max(pixel) / max(colour)
    return light > shade and all(abs(p - light * c) < 14 for p, c in zip(pixel, colour))


def centre(rows, colour):
    places = [(x, y) for y, row in enumerate(rows) for x, pixel in enumerate(row) if like(pixel, colour)]
    assert len(places) > 30, (colour, len(places))
    return sum(x for x, _ in places) / len(places), sum(y for _, y in places) / len(places)


def main():
    folder = tempfile.mkdtemp(prefix="godobject-view-")
    path = lambda name: os.path.join(folder, name)
    godobject("run", "sim/scenes/wall.toml", "--fast", "--duration", "4", "--trace", path("wall.csv"), "--report", path("report.json"))

    godobject("view", path("wall.csv"), "--picture", path("pressed.png"), "--time", "2.5")  # 35 mm in; the report names the scene
    rows, _ = image(path("pressed.png"))
    assert len(rows) == 600 and len(rows[0]) == 960
    (tool, _), (ghost, _) = centre(rows, TOOL), centre(rows, GHOST)
    assert ghost - tool > 15, ("the device is beyond the tool", ghost, tool)

    godobject("view", path("wall.csv"), "--picture", path("free.png"), "--time", "0", "--size", "320", "200")
    rows, _ = image(path("free.png"))
    assert len(rows) == 200
    centre(rows, TOOL)
    assert not any(like(pixel, GHOST) for row in rows for pixel in row), "in one place the device is hardly seen"

    godobject("view", path("wall.csv"), "--picture", path("moving.png"), "--duration", "1", "--size", "160", "100")
    assert image(path("moving.png"))[1] == 12

    godobject("view", path("wall.csv"), "--picture", path("pressed.gltf"), "--time", "2.5")
    with open(path("pressed.gltf"), encoding="utf-8") as file:
        gltf = json.load(file)
    names = [node["name"] for node in gltf["nodes"]]
    assert {"peg", "wall", "post", "peg, device", "coupling", "force to the hand"} <= set(names), names
    data = base64.b64decode(gltf["buffers"][0]["uri"].split(",")[1])
    assert len(data) == gltf["buffers"][0]["byteLength"]
    for accessor in gltf["accessors"]:
        view = gltf["bufferViews"][accessor["bufferView"]]
        assert view["byteLength"] == accessor["count"] * (12 if accessor["type"] == "VEC3" else 4)
        assert view["byteOffset"] + view["byteLength"] <= len(data)
    for mesh in gltf["meshes"]:
        primitive, = mesh["primitives"]
        order, points = (gltf["accessors"][primitive[key]] for key in ("indices",)), gltf["accessors"][primitive["attributes"]["POSITION"]]
        order = next(order)
        at = gltf["bufferViews"][order["bufferView"]]["byteOffset"]
        assert max(struct.unpack_from(f"<{order['count']}I", data, at)) < points["count"]
    peg = gltf["accessors"][gltf["meshes"][[m["name"] for m in gltf["meshes"]].index("peg")]["primitives"][0]["attributes"]["POSITION"]]
    assert peg["max"][0] < 0.082, "the peg ends at the wall"

    godobject("view", "sim/scenes/organ.toml", "--picture", path("organ.png"))
    rows, _ = image(path("organ.png"))
    centre(rows, WALL)
    seen = [(x, y) for y, row in enumerate(rows) for x, pixel in enumerate(row) if max(abs(a - b) for a, b in zip(pixel, rows[0][0])) > 8]
    left, right, top, bottom = (edge(xy[k] for xy in seen) for k in (0, 1) for edge in (min, max))
    assert 0 < left and right < 959 and 0 < top and bottom < 599, ("all is in the picture", left, right, top, bottom)
    assert bottom - top > 500, ("and fills it", top, bottom)

    godobject("view", "sim/scenes/grasper.toml", "--picture", path("grasper.png"))
    drawn = [pixel for row in image(path("grasper.png"))[0] for pixel in row if pixel[0] - pixel[2] > 60]
    assert sum(like(pixel, TOOL, 0.3) for pixel in drawn) > 0.95 * len(drawn) > 1000, "no stripes of the device on the tool"

    godobject("run", "sim/scenes/grasper.toml", "--fast", "--quiet", "--duration", "2", "--record", path("bus.log"))
    godobject("view", path("bus.log"), "--scene", "sim/scenes/grasper.toml", "--picture", path("bus.png"), "--time", "1.5")
    centre(image(path("bus.png"))[0], TOOL)
    # A log with a gap takes no longer than one without, and a truncated one is displayed up to the cut.
    lines = open(path("bus.log"), encoding="utf-8").read().splitlines()
    stamp = [float(line[1:line.index(")")]) for line in lines]
    for gap in (3600, 86400, 10_000_000):
        with open(path("gap.log"), "w", encoding="utf-8") as file:
            for t, line in zip(stamp, lines):
                file.write(f"({t + (gap if t > stamp[0] + 1 else 0):.6f}{line[line.index(')'):]}\n")
            file.write(lines[-1][:-3])
        begin = time.monotonic()
        godobject("view", path("gap.log"), "--scene", "sim/scenes/grasper.toml", "--picture", path("gap.png"), "--time", str(gap + 1.5))
        assert time.monotonic() - begin < 30, f"{time.monotonic() - begin} s for a gap of {gap} s"
        image(path("gap.png"))

    nets = ["--fast", "--quiet", "--duration", "1", "--trace", path("net.csv"), "--nets", path("nodes.csv"), "--report", path("report.json")]
    godobject("run", "sim/scenes/net-small.toml", *nets)
    godobject("view", path("net.csv"), "--picture", path("told.png"))  # the report names both
    godobject("view", path("net.csv"), "--nets", path("nodes.csv"), "--picture", path("given.png"))
    subprocess.run([ARGS.program, "view", path("net.csv"), "--picture", path("abroad.png")], cwd="/", timeout=120, check=True)
    assert image(path("abroad.png"))[0] == image(path("told.png"))[0], "seen from another folder, too"
    os.rename(path("nodes.csv"), path("elsewhere.csv"))
    godobject("view", path("net.csv"), "--picture", path("at-rest.png"))
    told, given, at_rest = (image(path(name))[0] for name in ("told.png", "given.png", "at-rest.png"))
    assert told == given and told != at_rest, "deformed where its nodes are known"
    godobject("run", "sim/scenes/wall.toml", "--fast", "--quiet", "--duration", "4", "--trace", path("wall.csv"), "--report", path("report.json"))
    assert "has no nets: remove --nets" in godobject("view", path("wall.csv"), "--nets", path("elsewhere.csv"), "--picture", path("x.png"), code=2)
    assert "requires a trace" in godobject("view", "sim/scenes/net-small.toml", "--nets", path("elsewhere.csv"), "--picture", path("x.png"), code=2)

    assert "describes no buses" in godobject("view", path("bus.log"), "--scene", "sim/scenes/wall.toml", "--picture", path("x.png"), code=2)
    os.remove(path("report.json"))
    assert "its scene is unknown: give the scene file with --scene" in godobject("view", path("wall.csv"), "--picture", path("x.png"), code=2)
    assert "must end in .png or .gltf" in godobject("view", path("wall.csv"), "--picture", path("x.jpg"), code=2)
    assert "is it of another scene" in godobject("view", path("wall.csv"), "--scene", "sim/scenes/organ.toml", "--picture", path("x.png"), code=2)


main()
