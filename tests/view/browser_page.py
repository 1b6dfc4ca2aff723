"""A page of the view in Chromium, without a screen, for the tests in this folder. Importing it skips the test if
selenium is missing."""
import base64
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import zlib

from viewed_run import SOURCE, ViewedRun, skip, share

FLAGS = ("--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking --disable-component-update "
         "--disable-sync --use-angle=swiftshader --enable-unsafe-swiftshader --window-size=900,620").split()
SLOW = 15  # s: limit of a page drawn in software, on a busy machine

try:
    from selenium import webdriver
    from selenium.common.exceptions import WebDriverException
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service
except ImportError:
    skip("no selenium: apt-get install python3-selenium")


def open_browser(profile):
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if not chromium or not driver:
        skip("no browser: apt-get install chromium chromium-driver")
    options = Options()
    options.binary_location = chromium
    for flag in [*FLAGS, "--user-data-dir=" + profile]:
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    try:
        return webdriver.Chrome(service=Service(driver), options=options)
    except WebDriverException as error:
        return skip(f"the browser does not start: {str(error).splitlines()[0]}")


class Page:
    def __init__(self, browser, url):
        self.browser = browser
        browser.get(url)
        self.wait("!!window.godobject", "the page's script runs")
        self.wait("performance.getEntriesByName('picture').length", "a first picture")
        self.first_picture_s = self.js("performance.getEntriesByName('picture')[0].startTime") / 1e3  # since the page was opened

    def js(self, text):
        return self.browser.execute_script("return " + text)

    def wait(self, condition, what, patience=SLOW):
        end = time.monotonic() + patience
        while not self.js(f"Boolean({condition})"):
            assert time.monotonic() < end, (what, self.js("window.godobject ? godobject.phase() : 'no script'"))
            time.sleep(0.02)

    def errors(self):
        return [entry["message"] for entry in self.browser.get_log("browser") if entry["level"] == "SEVERE" and "WebSocket" not in entry["message"]
                and "ERR_CONNECTION_REFUSED" not in entry["message"]]

    def pixels(self):
        """Returns the rows of the canvas, drawn now."""
        data = self.js("(() => { godobject.view.render(); return document.getElementById('canvas').toDataURL('image/png'); })()")
        return png_rows(base64.b64decode(data.split(",")[1]))


def png_rows(data):
    at, body, width, height, kind = 8, b"", 0, 0, 0
    while at < len(data):
        size, = struct.unpack_from(">I", data, at)
        if data[at + 4:at + 8] == b"IHDR":
            width, height, _, kind = struct.unpack_from(">IIBB", data, at + 8)
        if data[at + 4:at + 8] == b"IDAT":
            body += data[at + 8:at + 8 + size]
        at += 12 + size
    channels = {2: 3, 6: 4}[kind]
    raw, stride, rows, above = zlib.decompress(body), channels * width, [], bytearray(channels * width)
    for y in range(height):
        how, line = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            a = line[i - channels] if i >= channels else 0
            b = above[i]
            c = above[i - channels] if i >= channels else 0
            near = min((abs(b - c), 0, a), (abs(a - c), 1, b), (abs(a + b - 2 * c), 2, c))[2]
            line[i] = (line[i] + (0, a, b, (a + b) // 2, near)[how]) & 255
        above = line
        rows.append([tuple(line[x:x + 3]) for x in range(0, stride, channels)])
    return rows


def like(pixel, colour):
    """True for a pixel of this hue, in any light."""
    light = max(pixel) / max(colour)
    return light > 0.4 and all(abs(p - light * c) < 30 for p, c in zip(pixel, colour))


def press(browser, kind, key):
    browser.execute_script(f"dispatchEvent(new KeyboardEvent('{kind}', {{ key: '{key}' }}))")


def record(program, scene, folder, *options):
    """Returns the path of a trace of this scene."""
    trace = os.path.join(folder, scene + "-page.csv")
    if os.path.exists(trace):
        return trace
    subprocess.run([program, "run", f"sim/scenes/{scene}.toml", "--fast", "--quiet", "--duration", "3", "--trace", trace, *options],
                   cwd=SOURCE, check=True, timeout=120, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return trace


def view(program, trace, scene, folder):
    return ViewedRun(program, "view", trace, "--scene", f"sim/scenes/{scene}.toml", folder=folder)


def seek(page, t):
    page.js(f"(godobject.player.playing = false, godobject.player.showAt({t}))")
    page.wait(f"Math.abs(godobject.state.frame.t - {t}) < 0.011", "that instant")


def count(rows, colour):
    return sum(like(pixel, colour) for row in rows for pixel in row)


def run_in_browser(program, folder, tests):
    """Runs the share of the tests with a browser. Skips if chromium, WebGL or the page is missing."""
    with ViewedRun(program, "view", "sim/scenes/wall.toml", folder=folder) as run:
        if run.ask("/app.js")[0] != 200:
            skip("the program was built without its page: ./dev setup view, then build again")
    browser = open_browser(tempfile.mkdtemp(prefix="godobject-browser-"))
    try:
        browser.get("data:text/html,<canvas id=c></canvas>")
        if not browser.execute_script("return Boolean(document.getElementById('c').getContext('webgl2'))"):
            skip("this browser has no WebGL here")
        for test in share(tests):
            print(test.__name__)
            sys.stdout.flush()
            begin = time.monotonic()
            test(browser, folder)
            print(f"  {time.monotonic() - begin:.1f} s")
    finally:
        browser.quit()
