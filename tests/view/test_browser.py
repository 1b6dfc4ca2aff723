#!/usr/bin/env python3
"""The view's page in a real browser: the tool has the pose of the run, the device is beyond the wall, and the
pointer moves it. The page detects the end and the return of the run. Skipped if chromium, chromedriver,
selenium, WebGL or the page itself is missing.

usage: test_browser.py --program PATH
"""
import csv
import os
import signal
import tempfile
import threading
import time

from browser_page import Page, like, press, run_in_browser
from viewed_run import ViewedRun, arguments
from selenium.webdriver.common.action_chains import ActionChains

ARGS = arguments()
TOOL, GHOST = (0xD5, 0x45, 0x2C), (0xE0, 0x8A, 0x1E)


def centre_x(rows, colour):
    xs = [x for row in rows for x, pixel in enumerate(row) if like(pixel, colour)]
    assert len(xs) > 20, (colour, len(xs))
    return sum(xs) / len(xs)


def distance(a, b):
    return sum((x - y) ** 2 for x, y in zip(a[:3], b[:3])) ** 0.5


def print_first_pictures(browser, scene, url):
    times = sorted(Page(browser, url).first_picture_s for _ in range(5))
    print(f"  {scene}: first picture {times[2]:.2f} s after the page is opened, median of 5, {times[0]:.2f} to {times[-1]:.2f} s")


# ms: the page's own share of a picture (poses, drawing, texts), and a complete picture without a graphics
# card
COSTS = """(() => {
  const { view, state } = godobject, gl = view.renderer.getContext(), pixel = new Uint8Array(4), n = 30;
  let own = 0, whole = 0;
  for (let i = 0; i < n; ++i) {
    const begin = performance.now();
    view.update(state.frame);
    view.render();
    godobject.writeState(begin);
    own += performance.now() - begin;
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    whole += performance.now() - begin;
  }
  return [own / n, whole / n, view.width, view.height, view.renderer.info.render.calls, view.renderer.info.render.triangles];
})()"""


def print_costs(page, scene):
    drawn, begin = page.js("[godobject.drawn, performance.now()]")
    time.sleep(3)
    more, end = page.js("[godobject.drawn, performance.now()]")
    own, whole, width, height, calls, triangles = page.js(COSTS)
    print(f"  {scene}: {1e3 * (more - drawn) / (end - begin):.0f} frames/s in software at {width} x {height}; a frame is {own:.1f} ms of the page and "
          f"{whole - own:.0f} ms of drawing ({calls} calls, {triangles} triangles)")


def seen_on(page, tool):
    """Returns the cycle, the tool's position in the frame, and the drawn position."""
    return page.js(f"(godobject.view.update(godobject.state.frame), [godobject.state.frame.cycle, godobject.body('{tool}'), godobject.drawnAt('{tool}')])")


def test_the_tool_is_where_the_trace_says(browser, folder):
    for scene, tool, bus in (("grasper", "tube", []), ("organ", "tube", ["--bus", "direct"])):
        trace = os.path.join(folder, scene + ".csv")
        with ViewedRun(ARGS.program, "run", f"sim/scenes/{scene}.toml", *bus, "--view", "--duration", "120", "--trace", trace, folder=folder) as run:
            print_first_pictures(browser, scene, run.url)
            page = Page(browser, run.url)
            seen = []
            while len(seen) < 6 or (distance(seen[-1][1], seen[0][1]) < 2e-3 and len(seen) < 60):  # a held run rests
                seen.append(seen_on(page, tool))
                time.sleep(0.2)
            assert not page.errors(), page.errors()
        with open(trace, newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
        at = rows[0].index(tool + ".x")
        moved = 0.0
        for cycle, body, drawn in seen:
            told = [float(x) for x in rows[1 + cycle][at:at + 3]]  # row 1 is the state at the start
            assert distance(body, told) < 1e-6 and distance(drawn, told) < 1e-6, (scene, cycle, body, drawn, told)
            moved = max(moved, distance(told, seen[0][1]))
        assert moved > 1e-3, "it moves"


def test_all_onlookers_see_one_run(browser, folder):
    with ViewedRun(ARGS.program, "run", "sim/scenes/lego.toml", "--bus", "direct", "--view", "--duration", "120", folder=folder) as run:
        print_first_pictures(browser, "lego", run.url)
        page = Page(browser, run.url)
        print_costs(page, "lego")
        stream, frames = run.stream(), {}
        index = [body["name"] for body in stream.scene()["bodies"]].index("mover")

        def read():
            try:
                while True:
                    frame = stream.frame()
                    frames[frame["cycle"]] = frame["bodies"][index]
            except (ConnectionError, OSError):
                pass

        reader = threading.Thread(target=read)
        reader.start()
        time.sleep(0.5)
        seen = [seen_on(page, "mover") for _ in range(10)]
        time.sleep(0.5)
        run.end()
        reader.join()
        common = [(body, frames[cycle]) for cycle, body, _ in seen if cycle in frames]
        assert common, "one frame at least is the same"
        assert all(distance(a, b) == 0 for a, b in common)


def test_the_device_is_beyond_the_wall(browser, folder):
    with ViewedRun(ARGS.program, "run", "sim/scenes/wall.toml", "--view", "--duration", "120", folder=folder) as run:
        page = Page(browser, run.url)
        page.wait("godobject.target('peg')[0] - godobject.body('peg')[0] > 0.02", "pressed on the wall")
        tool, ghost = page.js("(godobject.view.update(godobject.state.frame), [godobject.drawnAt('peg'), godobject.ghostAt('peg')])")
        assert tool[0] < 0.067 < 0.08 < ghost[0] + 0.015, (tool, ghost)
        rows = page.pixels()
        assert centre_x(rows, GHOST) - centre_x(rows, TOOL) > 4, "apart in pixels"
        assert not page.errors(), page.errors()


def test_the_pointer_moves_the_tool(browser, folder):
    with ViewedRun(ARGS.program, "run", "sim/scenes/wall.toml", "--view", "--view-input", folder=folder) as run:
        page = Page(browser, run.url)
        peg, wall = page.js("[godobject.pixel(godobject.drawnAt('peg')), godobject.pixel([0.2, 0, 0])]")
        canvas = browser.find_element("id", "canvas")
        width, height = page.js("[godobject.view.width, godobject.view.height]")
        steps, hand = 20, ActionChains(browser, duration=40)
        hand.move_to_element_with_offset(canvas, int(peg["x"] - width / 2), int(peg["y"] - height / 2)).click_and_hold().perform()
        page.wait("godobject.state.frame.held === 0", "the tool is held")
        hand = ActionChains(browser, duration=40)
        for _ in range(steps):
            hand.move_by_offset(round((wall["x"] - peg["x"]) / steps), round((wall["y"] - peg["y"]) / steps))
        hand.perform()
        page.wait("godobject.target('peg')[0] > 0.1", "the target follows the pointer, into the wall")
        page.wait("Math.abs(godobject.body('peg')[0] - 0.065) < 0.004", "the tool stops at it")
        page.wait("Math.hypot(...godobject.state.frame.handForce) > 5", "the hand is pushed back")
        ActionChains(browser).release().perform()
        page.wait("godobject.state.frame.held === -1", "the button that goes up releases")
        press(browser, "keydown", "g")
        page.wait("godobject.state.frame.held === 0", "G takes hold")
        at = page.js("godobject.pixel(godobject.drawnAt('peg'))")
        ActionChains(browser, duration=40).move_to_element_with_offset(canvas, int(at["x"] - width / 2), int(at["y"] - height / 2)).click().perform()
        time.sleep(0.5)
        assert page.js("godobject.state.frame.held") == 0, "held on purpose, it stays"
        press(browser, "keydown", "Escape")
        page.wait("godobject.state.frame.held === -1", "released")
        assert not page.errors(), page.errors()


def hover(browser, page, body):
    """Moves the pointer onto the drawn body."""
    at, width, height = page.js(f"[godobject.pixel(godobject.drawnAt('{body}')), godobject.view.width, godobject.view.height]")
    canvas = browser.find_element("id", "canvas")
    ActionChains(browser, duration=40).move_to_element_with_offset(canvas, int(at["x"] - width / 2), int(at["y"] - height / 2)).perform()


def test_it_is_seen_what_a_press_would_drag(browser, folder):
    with ViewedRun(ARGS.program, "run", "sim/scenes/lego.toml", "--view", "--view-input", folder=folder) as run:
        page = Page(browser, run.url)
        names = page.js("godobject.state.about.driven.map((body) => godobject.state.about.bodies[body].name)")
        for name in names[:2]:
            hover(browser, page, name)
            page.wait("godobject.pointer.hover !== null", f"a body under the pointer, at {name}")
            page.wait("document.getElementById('hover').textContent === 'drags ' + godobject.state.about.bodies[godobject.state.about.driven[godobject.pointer.hover]].name",
                      "its name is shown")
            lit = page.js("godobject.view.bodies.filter((body) => body.children.some((mesh) => mesh.isMesh && mesh.material.emissive?.getHex())).map((body) => body.userData.target)")
            assert lit == [page.js("godobject.pointer.hover")], lit
        assert not page.errors(), page.errors()


def test_wheel_and_keys_move_joints(browser, folder):
    with ViewedRun(ARGS.program, "run", "sim/scenes/grasper.toml", "--view", "--view-input", folder=folder) as run:
        page = Page(browser, run.url)
        assert page.js("godobject.pointer.joints.coordinates.map((one) => one.name)") == ["pitch", "yaw", "roll", "insertion", "left", "right"]
        page.wait("godobject.state.frame.t > 1", "engaged")
        before = page.js("godobject.body('tube')")
        press(browser, "keydown", "4")
        press(browser, "keydown", "ArrowUp")
        time.sleep(0.5)
        press(browser, "keyup", "ArrowUp")
        page.wait("!godobject.pointer.joints.holds", "the keys are up")
        time.sleep(0.5)
        after = page.js("godobject.body('tube')")
        assert 0.01 < distance(before, after) < 0.12, (before, after)
        # a pixel of the tube that no other body hides
        at = page.js("""(() => {
            const box = document.getElementById('canvas').getBoundingClientRect(), { about } = godobject.state, tube = about.driven.indexOf(godobject.names().indexOf('tube'));
            for (let y = 4; y < box.height; y += 4)
                for (let x = 4; x < box.width; x += 4)
                    if (godobject.pointer.under({ clientX: box.left + x, clientY: box.top + y })?.target === tube) return { clientX: box.left + x, clientY: box.top + y };
            return null;
        })()""")
        assert at, "a pixel of the tube"
        browser.execute_script("document.getElementById('canvas').dispatchEvent(new PointerEvent('pointermove', arguments[0]));", at)
        page.wait("document.getElementById('hover').textContent.endsWith('tube · wheel: insertion · shift+wheel: roll')", "the wheel's coordinates are named")
        browser.execute_script("for (let i = 0; i < 5; ++i) document.getElementById('canvas').dispatchEvent(new WheelEvent('wheel', { ...arguments[0], deltaY: 100, cancelable: true }));", at)
        time.sleep(1)
        moved = distance(after, page.js("godobject.body('tube')"))
        assert 0.01 < moved < 0.025, (moved, page.js("[godobject.phase(), godobject.state.frame.flags]"))
        assert not page.errors(), page.errors()


def test_the_page_knows_when_the_run_is_gone(browser, folder):
    arguments_ = ("run", "sim/scenes/wall.toml", "--view", "7795", "--duration", "300")
    with ViewedRun(ARGS.program, *arguments_, folder=folder) as run:
        page = Page(browser, run.url)
        run.process.send_signal(signal.SIGKILL)
        killed = time.monotonic()
        page.wait("/lost|ended/.test(godobject.phase())", "the page says so", 5)
        print(f"  said after {time.monotonic() - killed:.2f} s")
        assert time.monotonic() - killed < 1.5, "within a second, and what a busy machine needs"
        assert page.js("document.body.classList.contains('stale')")
    with ViewedRun(ARGS.program, *arguments_, folder=folder):
        page.wait("/^running/.test(godobject.phase()) && !document.body.classList.contains('stale')", "it comes back by itself")
    page.wait("/ended/.test(godobject.phase())", "a run that ends says so")


def test_a_recording_has_a_slider(browser, folder):
    trace = os.path.join(folder, "t.csv")
    with ViewedRun(ARGS.program, "run", "sim/scenes/wall.toml", "--fast", "--view", "--duration", "20", "--trace", trace, "--trace-every", "10", folder=folder) as run:
        time.sleep(2)
        run.end()
    with ViewedRun(ARGS.program, "view", trace, "--scene", "sim/scenes/wall.toml", folder=folder) as run:
        page = Page(browser, run.url)
        page.js("godobject.player.playing = false, godobject.player.showAt(2.5)")
        # repeated until it is there; a longer recording is thinned out
        page.wait("(godobject.player.showAt(2.5), Math.abs(godobject.state.frame.t - 2.5) < 0.02 && godobject.target('peg')[0] > 0.09)", "the instant that was asked for")
        assert not page.js("document.getElementById('player').hidden")
        page.js("godobject.player.toggle()")
        page.wait("godobject.state.frame.t > 2.8", "it plays")
        assert not page.errors(), page.errors()


def main():
    run_in_browser(ARGS.program, tempfile.mkdtemp(prefix="godobject-view-"), (
        test_the_tool_is_where_the_trace_says, test_all_onlookers_see_one_run, test_the_device_is_beyond_the_wall, test_the_pointer_moves_the_tool,
        test_it_is_seen_what_a_press_would_drag, test_wheel_and_keys_move_joints, test_the_page_knows_when_the_run_is_gone, test_a_recording_has_a_slider))


main()
