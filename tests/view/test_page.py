#!/usr/bin/env python3
"""What a user does with the view's page: clicks a body, pauses and steps a run, takes pictures and films. What
the page draws: everything in the first picture, no stripes, the tool behind obstacles, the scale of forces.

usage: test_page.py --program PATH
"""
import base64
import csv
import math
import os
import struct
import subprocess
import tempfile
import time

from browser_page import Page, like, png_rows, press, run_in_browser
from viewed_run import SOURCE, ViewedRun, arguments
from selenium.webdriver.common.action_chains import ActionChains

ARGS = arguments()
TOOL = (0xD5, 0x45, 0x2C)


def record(scene, folder, *options):
    """Returns the path of a trace of this scene."""
    trace = os.path.join(folder, scene + "-page.csv")
    if os.path.exists(trace):
        return trace
    subprocess.run([ARGS.program, "run", f"sim/scenes/{scene}.toml", "--fast", "--quiet", "--duration", "3", "--trace", trace, *options],
                   cwd=SOURCE, check=True, timeout=120, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return trace


def view(trace, scene, folder):
    return ViewedRun(ARGS.program, "view", trace, "--scene", f"sim/scenes/{scene}.toml", folder=folder)


def select(page, kind, name):
    page.browser.execute_script("""const { list, things } = godobject.inspector;
        list.value = things.findIndex((thing) => thing.kind === arguments[0] && thing.name === arguments[1]); list.onchange();""", kind, name)
    page.wait("document.querySelector('#inspector dd')", f"facts of {kind} {name}")
    return page.js("Object.fromEntries([...document.querySelectorAll('#inspector dt')].map((dt) => [dt.textContent, dt.nextSibling.textContent]))")


def seek(page, t):
    page.js(f"(godobject.player.playing = false, godobject.player.showAt({t}))")
    page.wait(f"Math.abs(godobject.state.frame.t - {t}) < 0.011", "that instant")


def test_a_click_shows_a_body_with_its_curves(browser, folder):
    trace = record("grasper", folder)
    with open(trace, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    with view(trace, "grasper", folder) as run:
        page = Page(browser, run.url)
        seek(page, 2)
        t = page.js("godobject.state.frame.t")
        row = min(rows, key=lambda one: abs(float(one["t"]) - t))
        at, width, height = page.js("""(() => {
            const { view } = godobject, tube = view.bodies[godobject.names().indexOf('tube')], part = tube.position.clone().set(0, 0, 0.1);
            return [view.project(tube.localToWorld(part).toArray()), view.width, view.height];
        })()""")  # between the trocar and the jaws
        canvas = browser.find_element("id", "canvas")
        ActionChains(browser, duration=40).move_to_element_with_offset(canvas, int(at["x"] - width / 2), int(at["y"] - height / 2)).click().perform()
        page.wait("godobject.inspector.thing?.name === 'tube'", "the click selects it")
        page.wait("document.querySelectorAll('#inspector .u-title').length >= 2", "curves of its own")
        facts = select(page, "body", "tube")
        position = [float(x) for x in facts["position"].removesuffix(" mm").split(", ")]
        assert all(abs(1e-3 * a - float(row["tube." + k])) < 1e-4 for a, k in zip(position, "xyz")), (facts, row["tube.x"])
        times, xs = page.js("[godobject.inspector.strips.times, godobject.inspector.strips.columns[0][0]]")
        assert len(times) == page.js("godobject.player.frames.length")
        by_time = {round(float(one["t"]), 4): float(one["tube.x"]) for one in rows}
        assert all(abs(1e-3 * x - by_time[round(t, 4)]) < 1e-6 for t, x in zip(times, xs)), "the curve is that of the trace"

        joint, drive = page.js("[godobject.state.about.joints[0].name, godobject.state.about.values.find((value) => value.name === 'drive torque').index]")
        facts = select(page, "joint", joint)
        force = math.sqrt(sum(float(row[f"{joint}.f{k}"]) ** 2 for k in "xyz"))
        assert abs(float(facts["force"].split()[0]) - force) < 1e-3 * max(1, force), (facts, force)
        drive = page.js(f"godobject.state.about.device_joints[{drive}]")
        facts = select(page, "device", drive)
        assert abs(float(facts["drive torque"].split()[0]) - float(row[f"drive.{drive}.torque"])) < 1e-5, (facts, row[f"drive.{drive}.torque"])
        assert abs(math.radians(float(facts["angle"].split()[0])) - float(row[f"device.{drive}.q"])) < 1e-4
        # every label of an axis is inside its plot
        page.wait("document.querySelectorAll('#inspector canvas').length >= 2", "drawn")
        assert page.js("godobject.inspector.strips.plots.every((plot) => plot.axes[1]._values.every((text) => 6 * text.length + 8 < plot.axes[1]._size))")
        assert not page.errors(), page.errors()


def cycle(page):
    return page.js("godobject.player.latest.cycle")


def rate(page, seconds):
    """Returns simulated time per wall time."""
    begin = page.js("[godobject.player.latest.t, performance.now()]")
    time.sleep(seconds)
    end = page.js("[godobject.player.latest.t, performance.now()]")
    return (end[0] - begin[0]) / (end[1] - begin[1]) * 1e3


def set_speed(page, speed):
    page.browser.execute_script("const { speed } = godobject.player; speed.value = arguments[0]; speed.onchange();", speed)


def test_a_run_without_hardware_pauses_steps_and_slows(browser, folder):
    for options, slow, most in ((("--view-input",), "0.1", 0.2), (("--fast", "--bus", "direct", "--duration", "1000000"), "0.25", 0.5)):
        with ViewedRun(ARGS.program, "run", "sim/scenes/wall.toml", "--view", *options, folder=folder) as run:
            page = Page(browser, run.url)
            page.wait("/^running/.test(godobject.phase())", "it runs")
            press(browser, "keydown", " ")
            page.wait("godobject.phase() === 'the run is paused'", "paused")
            time.sleep(0.1)
            before = cycle(page)
            time.sleep(0.7)
            assert cycle(page) == before, "it stands still"
            assert not page.js("document.body.classList.contains('stale')"), "and is not stale"
            for n in (1, 2):
                press(browser, "keydown", "ArrowRight")
                page.wait(f"godobject.player.latest.cycle === {before + n}", "one period more", 5)
            set_speed(page, slow)
            press(browser, "keydown", " ")
            page.wait(f"godobject.player.latest.cycle > {before + 30}", "it goes on")
            slowly = rate(page, 1)
            assert 0 < slowly < most, slowly  # a busy machine is slower, never faster
            press(browser, "keydown", " ")
            page.wait("godobject.phase() === 'the run is paused'", "paused again")
            stream = run.stream()
            stream.scene()
            held = stream.frame()
            assert held["flags"] & 16
            browser.get("about:blank")  # the page that paused it is gone
            end = time.monotonic() + 10
            while stream.frame()["cycle"] <= held["cycle"] + 10:
                assert time.monotonic() < end, "the run goes on without the page"
            assert not page.errors(), page.errors()


def test_a_run_in_wall_time_goes_on_under_a_paused_picture(browser, folder):
    with ViewedRun(ARGS.program, "run", "sim/scenes/wall.toml", "--view", "--duration", "300", folder=folder) as run:
        page = Page(browser, run.url)
        page.wait("/^running/.test(godobject.phase())", "it runs")
        press(browser, "keydown", " ")
        page.wait("godobject.phase() === 'the picture is paused; the run goes on'", "said")
        shown, latest = page.js("[godobject.state.frame.cycle, godobject.player.latest.cycle]")
        page.wait(f"godobject.player.latest.cycle > {latest + 100}", "the run goes on")
        assert page.js("godobject.state.frame.cycle") == shown, "the picture stands"
        for key, is_there in (("ArrowLeft", "<"), ("ArrowRight", "===")):
            press(browser, "keydown", key)
            page.wait(f"godobject.state.frame.cycle {is_there} {shown}", "earlier frames of the run, and back")
        stream = run.stream()
        stream.scene()
        stream.send(struct.pack("<IHHf", 0x43564F47, 1, 0, 0.0))
        begin = stream.frame()["cycle"]
        while stream.frame()["cycle"] < begin + 200:
            continue
        assert "a pause was ignored" in run.text()
        press(browser, "keydown", " ")
        page.wait("/^running/.test(godobject.phase())", "it goes on")
        colours = page.js("getComputedStyle(document.getElementById('canvas')).filter")
        run.end()
        page.wait("/^ended/.test(godobject.phase())", "the end is stated")
        time.sleep(0.8)
        assert page.js("godobject.phase()") == "ended: the last picture"
        assert page.js("getComputedStyle(document.getElementById('canvas')).filter") == colours == "none", "in its colours"
        assert page.js("document.getElementById('banner').hidden")


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


def count(rows, colour):
    return sum(like(pixel, colour) for row in rows for pixel in row)


def differing(a, b, by=12):
    return sum(max(abs(x - y) for x, y in zip(p, q)) > by for row, other in zip(a, b) for p, q in zip(row, other))


def test_what_coincides_leaves_no_stripes_and_what_hides_the_tool_shows_it(browser, folder):
    trace = record("wall", folder, "--bus", "direct")
    with view(trace, "wall", folder) as run:
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
    trace = record("wall", folder, "--bus", "direct")
    known = [tuple(int(word[i:i + 2], 16) for i in (0, 2, 4)) for word in WALL.split()]
    with view(trace, "wall", folder) as run:
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


def test_pictures_films_and_a_contact_sheet_are_files(browser, folder):
    trace = record("wall", folder, "--bus", "direct")
    with view(trace, "wall", folder) as run:
        page = Page(browser, run.url)
        browser.execute_script("godobject.blobs = []; const keep = godobject.camera.keep; godobject.camera.keep = (blob, name) => { godobject.blobs.push({ blob, name }); return blob; };")
        browser.find_element("id", "film").click()
        page.wait("godobject.camera.recorder", "recording")
        time.sleep(1)
        browser.find_element("id", "film").click()
        page.wait("godobject.blobs.length === 1", "a film")
        browser.find_element("id", "screenshot").click()
        page.wait("godobject.blobs.length === 2", "a picture")
        browser.find_element("id", "sheet").click()
        page.wait("godobject.blobs.length === 3", "a contact sheet")
        files = browser.execute_async_script("""const done = arguments[0];
            Promise.all(godobject.blobs.map(async ({ blob, name }) => [name, btoa(Array.from(new Uint8Array(await blob.arrayBuffer()), (c) => String.fromCharCode(c)).join(''))])).then(done);""")
        (film_name, film), (picture_name, picture), (sheet_name, sheet) = [(name, base64.b64decode(data)) for name, data in files]
        assert film_name.endswith(".webm") and film[:4] == b"\x1a\x45\xdf\xa3" and len(film) > 3000, (film_name, len(film))
        width, height = struct.unpack_from(">II", picture, 16)
        assert picture_name.startswith("wall-") and [width, height] == page.js("[godobject.view.renderer.domElement.width, godobject.view.renderer.domElement.height]")
        assert count(png_rows(picture), TOOL) > 50, "the tool is on it"
        assert sheet_name.endswith("-sheet.png") and sheet[:8] == b"\x89PNG\r\n\x1a\n" and struct.unpack_from(">I", sheet, 16)[0] == 1600
        tiles = browser.execute_async_script("""const done = arguments[0];
            createImageBitmap(godobject.blobs[2].blob).then((image) => {
              const canvas = new OffscreenCanvas(80, 60), pen = canvas.getContext('2d'), w = image.width / 4, h = image.height / 3;
              done([[0, 0], [2, 1]].map(([i, j]) => { pen.drawImage(image, i * w + 60, j * h + 30, w - 70, h - 40, 0, 0, 80, 60); return [...pen.getImageData(0, 0, 80, 60).data]; }));
            });""")
        assert sum(abs(a - b) > 12 for a, b in zip(*tiles)) > 100, "its pictures differ"
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
        test_a_click_shows_a_body_with_its_curves, test_a_run_without_hardware_pauses_steps_and_slows,
        test_a_run_in_wall_time_goes_on_under_a_paused_picture, test_the_first_picture_shows_all,
        test_what_coincides_leaves_no_stripes_and_what_hides_the_tool_shows_it, test_the_picture_is_the_known_one, test_names_frames_and_the_scale_of_forces,
        test_pictures_films_and_a_contact_sheet_are_files, test_the_ground_has_shadows))


main()
