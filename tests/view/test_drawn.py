#!/usr/bin/env python3
"""What the view's page draws: everything in the first picture, no stripes, the tool behind obstacles, names, the
scale of forces, shadows.

usage: test_drawn.py --program PATH
"""
import os
import tempfile

from browser_page import Page, count, press, record, run_in_browser, seek, view
from viewed_run import ViewedRun, arguments

ARGS = arguments()
TOOL = (0xD5, 0x45, 0x2C)


# Returns the bounds of all drawn vertices in the picture, from 0 to 1.
FILLED = """(() => {
  const { view } = godobject, x = [], y = [], point = view.camera.position.clone();
  view.update(godobject.state.frame);
  view.render();
  view.world.updateMatrixWorld(true);
  for (const group of [...view.bodies, view.world])
    for (const mesh of group.children) {
      if (!mesh.isMesh || !mesh.userData.solid || mesh.userData.solid.kind === 'plane') continue;
      const at = mesh.geometry.attributes.position;
      for (let i = 0; i < at.count; ++i) {
        const seen = view.project(point.fromBufferAttribute(at, i).applyMatrix4(mesh.matrixWorld).toArray());
        x.push(seen.x / view.width);
        y.push(seen.y / view.height);
      }
    }
  const least = (list) => list.reduce((a, b) => Math.min(a, b)), most = (list) => list.reduce((a, b) => Math.max(a, b));
  return [least(x), most(x), least(y), most(y)];
})()"""


def test_the_first_picture_shows_all(browser, folder):
    for scene in ("grasper", "organ", "lego"):
        with ViewedRun(ARGS.program, "view", f"sim/scenes/{scene}.toml", folder=folder) as run:
            left, right, top, bottom = Page(browser, run.url).js(FILLED)
            assert 0 <= left < right <= 1 and 0 <= top < bottom <= 1, (scene, left, right, top, bottom)
            assert max(right - left, bottom - top) > 0.6, (scene, left, right, top, bottom)


def differing(a, b, by=12):
    return sum(max(abs(x - y) for x, y in zip(p, q)) > by for row, other in zip(a, b) for p, q in zip(row, other))


def test_what_coincides_leaves_no_stripes_and_what_hides_the_tool_shows_it(browser, folder):
    trace = record(ARGS.program, "wall", folder, "--bus", "direct")
    with view(ARGS.program, trace, "wall", folder) as run:
        page = Page(browser, run.url)
        seek(page, 0)
        shown = {}
        for ghost in ("true", "false"):
            page.js(f"(godobject.view.show.ghost = {ghost}, godobject.view.show.arrows = false, godobject.view.update(godobject.state.frame))")
            shown[ghost] = page.pixels()
        assert differing(shown["true"], shown["false"]) < 20, "the device in the same place is not drawn over the tool"
        # from behind the wall
        page.js("""(() => { const { view } = godobject; view.controls.target.fromArray(godobject.drawnAt('peg'));
            view.camera.position.copy(view.controls.target).add({ x: 0.9, y: 0.02, z: 0.03 }); })()""")
        hidden = count(page.pixels(), TOOL)
        reddish = [pixel for row in page.pixels() for pixel in row if pixel[0] > pixel[2] + 45 and pixel[0] > pixel[1] + 30]
        page.js("godobject.view.bodies.forEach((body) => body.children.forEach((mesh) => { if (mesh.userData.hidden) mesh.userData.hidden.visible = false; }))")
        without = [pixel for row in page.pixels() for pixel in row if pixel[0] > pixel[2] + 45 and pixel[0] > pixel[1] + 30]
        assert len(reddish) > len(without) + 100, (hidden, len(reddish), len(without))
        assert not page.errors(), page.errors()


# Mean colours of the parts of a picture of the wall at 2.5 s, row by row.
WALL = """
f4f5f7 f3f4f6 f2f3f4 f4f5f7 f4f5f7 dedfdf aaa7a2 cecdcb ededee f4f5f7 f4f5f7 f4f5f7
f4f5f7 d4d3d2 9e9c98 f4f5f7 f4f5f7 d5d4d3 837163 7c776b 858076 a19f98 d4d4d4 f4f5f7
f3f4f6 e1e2e2 827f7b eff1f4 eef0f3 c8c4ca 8e4337 7d766a 7a766c 706c65 c2c2c1 f4f5f7
eeeff2 edeff2 77756f eef0f3 dce6f0 d7d5d7 835e4e 7c766b 7a766c 6d6a63 d8d9db f0f1f4
eff1f3 f0f1f4 8b8985 e7e8eb f0f1f4 f0f1f4 c4c3c2 7b786e 7a766c 706d67 eef0f2 f0f1f4
f1f2f5 f1f2f4 f0f1f4 f1f2f5 f1f2f5 f1f2f5 f1f2f5 c9c9c8 7c786f 878481 f1f2f5 f1f2f5
f2f3f5 f1f2f5 f1f3f5 f1f3f5 f1f3f5 f1f3f5 f2f3f5 f2f3f5 cfcfcf cccccc f1f3f5 f1f3f5
f2f3f6 f2f3f5 f2f3f5 f2f3f5 f2f3f5 f2f3f5 f2f3f5 f2f3f5 f2f3f6 f2f3f6 f2f3f6 f2f3f5
"""


def parts(rows, columns=12, lines=8):
    """Returns the mean colour of each part of a picture."""
    width, height, means = len(rows[0]) // columns, len(rows) // lines, []
    for j in range(lines):
        for i in range(columns):
            pixels = [pixel for row in rows[j * height:(j + 1) * height] for pixel in row[i * width:(i + 1) * width]]
            means.append(tuple(sum(pixel[k] for pixel in pixels) / len(pixels) for k in range(3)))
    return means


def apart(a, b):
    """Returns the largest and the mean distance of the parts of two pictures, in steps of a colour."""
    distances = [max(abs(x - y) for x, y in zip(p, q)) for p, q in zip(a, b)]
    return max(distances), sum(distances) / len(distances)


def test_the_picture_is_the_known_one(browser, folder):
    trace = record(ARGS.program, "wall", folder, "--bus", "direct")
    known = [tuple(int(word[i:i + 2], 16) for i in (0, 2, 4)) for word in WALL.split()]
    with view(ARGS.program, trace, "wall", folder) as run:
        page = Page(browser, run.url)
        browser.execute_script("Object.assign(document.getElementById('stage').style, { flex: 'none', width: '480px', height: '320px' })")
        seek(page, 2.5)
        page.js("(godobject.view.setTheme('light'), godobject.view.lookAtAll(), godobject.view.update(godobject.state.frame))")
        drawn = parts(page.pixels())
        if "GODOBJECT_PRINT_PICTURES" in os.environ:
            print("\n".join(" ".join("".join(f"{round(x):02x}" for x in drawn[12 * j + i]) for i in range(12)) for j in range(8)))
        largest, mean = apart(drawn, known)
        assert largest < 20 and mean < 3, (largest, mean)  # edges may be drawn by other rules
        page.js("godobject.view.bodies[0].visible = false")
        assert apart(parts(page.pixels()), known)[0] > 40, "without its tool it is another one"


def test_names_frames_and_the_scale_of_forces(browser, folder):
    with ViewedRun(ARGS.program, "view", "sim/scenes/grasper.toml", folder=folder) as run:
        page = Page(browser, run.url)
        for key in ("n", "o"):
            press(browser, "keydown", key)
        labels = page.js("godobject.view.marks.labels.filter((one) => one.visible).map((one) => one.userData.text)")
        about = page.js("godobject.state.about")
        assert labels == [one["name"] for one in about["bodies"] + about["joints"]], labels
        assert page.js("godobject.view.marks.frames.length") == len(about["bodies"])
        bare = page.js("document.getElementById('show-labels').checked")
        assert bare
        with_names = page.pixels()
        press(browser, "keydown", "n")
        assert differing(with_names, page.pixels()) > 200, "the names are drawn"
        legend = []
        for _ in range(2):
            newtons, pixels, drawn = page.js("""(() => {
                const { view } = godobject, { newtons, pixels } = view.forceLegend(), at = view.controls.target.clone();
                const right = at.clone().setFromMatrixColumn(view.camera.matrixWorld, 0).multiplyScalar(newtons * view.forceScale()).add(at);
                return [newtons, pixels, view.project(right.toArray()).x - view.project(at.toArray()).x];
            })()""")
            assert abs(pixels - drawn) < 1 and 20 < pixels <= 61, (newtons, pixels, drawn)
            page.wait(f"document.getElementById('scale').textContent.trim() === '{newtons:g} N'", "stated in newtons")
            legend.append(newtons / pixels)
            press(browser, "keydown", "+")
        assert abs(legend[0] / legend[1] - 2) < 1e-6, "+ doubles the length of arrows"
        assert not page.errors(), page.errors()


def test_the_ground_has_shadows(browser, folder):
    with ViewedRun(ARGS.program, "view", "sim/scenes/wall.toml", folder=folder) as run:
        page = Page(browser, run.url)
        assert not page.js("document.getElementById('show-shadows').checked"), "off where drawing is done in software"
        bare = page.pixels()
        press(browser, "keydown", "h")
        shaded = page.pixels()
        darker = sum(sum(q) < sum(p) - 20 for row, other in zip(bare, shaded) for p, q in zip(row, other))
        lighter = sum(sum(q) > sum(p) + 20 for row, other in zip(bare, shaded) for p, q in zip(row, other))
        assert darker > 500 > lighter, (darker, lighter)
        assert not page.errors(), page.errors()


def main():
    run_in_browser(ARGS.program, tempfile.mkdtemp(prefix="godobject-view-"), (
        test_the_first_picture_shows_all,
        test_what_coincides_leaves_no_stripes_and_what_hides_the_tool_shows_it,
        test_the_picture_is_the_known_one,
        test_names_frames_and_the_scale_of_forces,
        test_the_ground_has_shadows))


main()
