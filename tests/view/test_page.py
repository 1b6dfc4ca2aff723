#!/usr/bin/env python3
"""What a user does with the view's page: clicks a body, pauses and steps a run, takes pictures and films.

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

from browser_page import Page, count, png_rows, press, record, run_in_browser, seek, view
from viewed_run import ViewedRun, arguments
from selenium.webdriver.common.action_chains import ActionChains

ARGS = arguments()
TOOL = (0xD5, 0x45, 0x2C)


def select(page, kind, name):
    page.browser.execute_script("""const { list, things } = godobject.inspector;
        list.value = things.findIndex((thing) => thing.kind === arguments[0] && thing.name === arguments[1]); list.onchange();""", kind, name)
    page.wait("document.querySelector('#inspector dd')", f"facts of {kind} {name}")
    return page.js("Object.fromEntries([...document.querySelectorAll('#inspector dt')].map((dt) => [dt.textContent, dt.nextSibling.textContent]))")


def test_a_click_shows_a_body_with_its_curves(browser, folder):
    trace = record(ARGS.program, "grasper", folder)
    with open(trace, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    with view(ARGS.program, trace, "grasper", folder) as run:
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

        press(browser, "keydown", "j")
        places = page.js("""(() => {
            const { view } = godobject, place = view.camera.position.clone();
            return view.joints.map((joint) => view.project(joint.getWorldPosition(place).toArray()));
        })()""")
        at = places[-1]
        there = [name for name, one in zip(page.js("godobject.state.about.joints.map((joint) => joint.name)"), places)
                 if math.hypot(one["x"] - at["x"], one["y"] - at["y"]) < 5]
        ActionChains(browser, duration=40).move_to_element_with_offset(canvas, int(at["x"] - width / 2), int(at["y"] - height / 2)).click().perform()
        page.wait("godobject.inspector.thing?.kind === 'joint'", "a click on a shown joint selects it")
        assert page.js("godobject.inspector.thing.name") in there, (page.js("godobject.inspector.thing.name"), there)

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


def test_a_run_without_hardware_starts_again(browser, folder):
    ways = [("--view-input",), ("--fast",)]
    if "GODOBJECT_SANITIZED" not in os.environ:  # its run-time library makes calls that the seal refuses
        ways.append(("--seal",))
    for way in ways:
        options = [*way, "--duration", "1000000"]
        with ViewedRun(ARGS.program, "run", "sim/scenes/wall.toml", "--view", *options, folder=folder) as run:
            page = Page(browser, run.url)
            page.wait("godobject.player.latest.cycle > 300", "it runs")
            start = page.js("(godobject.before = godobject.inspector.history[0], godobject.state.about.bodies[0])")
            if "--seal" not in options:
                press(browser, "keydown", " ")
                page.wait("godobject.phase() === 'the run is paused'", "paused")
            before = cycle(page)
            browser.find_element("id", "reset").click()
            page.wait(f"godobject.player.latest.cycle < {before}", "the time is back")
            if "--seal" not in options:
                page.wait("godobject.player.latest.cycle === 0 && godobject.player.latest.t === 0", "paused at the start")
                x, y, z = page.js("godobject.body(godobject.names()[0]).slice(0, 3)")
                assert all(abs(a - b) < 1e-6 for a, b in zip((x, y, z), start["pose"])), (start, x, y, z)
                press(browser, "keydown", "ArrowRight")
                page.wait("godobject.player.latest.cycle === 1", "one period")
                assert page.js("godobject.inspector.history.length") <= 2, "the curves are those of this run"
                press(browser, "keydown", " ")
            page.wait("godobject.player.latest.cycle > 100", "it runs again")
            press(browser, "keydown", "Home")
            page.wait("!document.body.classList.contains('stale')", "not stale")
            assert run.process.poll() is None
            assert "a page has reset the run: it starts again" in run.text(), run.text()
            assert not page.errors(), page.errors()
            assert run.end() == 0, run.text()


def test_a_run_that_writes_its_steps_refuses_a_reset(browser, folder):
    with ViewedRun(ARGS.program, "run", "sim/scenes/wall.toml", "--view", "--view-input", "--record", f"{folder}/kept.godo", folder=folder) as run:
        page = Page(browser, run.url)
        page.wait("godobject.player.latest.cycle > 100", "it runs")
        assert page.js("godobject.player.resetButton.disabled")
        why = page.js("godobject.player.resetButton.title")
        assert "kept.godo, whose steps follow one another" in why, why
        stream = run.stream()
        stream.scene()
        before = stream.frame()["cycle"]
        stream.send(struct.pack("<IHH", 0x52564F47, 1, 0))
        while stream.frame()["cycle"] < before + 100:
            continue
        assert f"a reset was ignored: {why}" in run.text(), run.text()
        assert run.end() == 0, run.text()
    replayed = subprocess.run([ARGS.program, "replay", f"{folder}/kept.godo"], capture_output=True, text=True, timeout=120)
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr


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


def test_pictures_films_and_a_contact_sheet_are_files(browser, folder):
    trace = record(ARGS.program, "wall", folder, "--bus", "direct")
    with view(ARGS.program, trace, "wall", folder) as run:
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


def test_sound_of_impacts_and_distance(browser, folder):
    with ViewedRun(ARGS.program, "run", "sim/scenes/wall.toml", "--view", "--bus", "direct", "--fast", "--duration", "1000000", folder=folder) as run:
        page = Page(browser, run.url)
        page.wait("godobject.state.frame?.numImpacts > 0", "the tool meets the wall")
        assert page.js("godobject.cues.knocks") == 0 and not page.js("Boolean(godobject.cues.audio)"), "silent until asked"
        browser.find_element("id", "sound").click()
        page.wait("godobject.cues.knocks > 0 && godobject.cues.hum > 0", "knocks, and hums while the wall holds the tool")
        assert 0 < page.js("godobject.cues.loudest") < 1, "m/s"
        browser.find_element("id", "sound").click()
        knocks = page.js("godobject.cues.knocks")
        page.wait("godobject.state.frame.numImpacts > 0", "another impact")
        assert page.js("godobject.cues.knocks") == knocks
        assert not page.errors(), page.errors()


def main():
    run_in_browser(ARGS.program, tempfile.mkdtemp(prefix="godobject-view-"), (
        test_sound_of_impacts_and_distance,
        test_a_click_shows_a_body_with_its_curves,
        test_a_run_without_hardware_pauses_steps_and_slows,
        test_a_run_without_hardware_starts_again,
        test_a_run_that_writes_its_steps_refuses_a_reset,
        test_a_run_in_wall_time_goes_on_under_a_paused_picture,
        test_pictures_films_and_a_contact_sheet_are_files))


main()
