#!/usr/bin/env python3
"""Valid and invalid clients of a view: invalid ones are refused and logged, and none affects the loop.

usage: test_clients.py --program PATH
"""
import json
import os
import random
import socket
import subprocess
import threading
import time

from viewed_run import SOURCE, ViewedRun, Stream, arguments, pointer, share

ARGS = arguments()
WALL = ("run", "sim/scenes/wall.toml", "--view", "--duration", "300")


def wait_for(condition, what, patience=10):
    end = time.monotonic() + patience
    while not condition():
        assert time.monotonic() < end, what
        time.sleep(0.02)


def still_serves(run):
    stream = run.stream()
    assert stream.status == 101
    assert stream.scene()["name"] in ("wall", "grasper")
    first, second = stream.frame(), stream.frame()
    assert second["cycle"] > first["cycle"], "the loop goes on"
    stream.close()


def test_a_stream(run):
    stream = run.stream(Origin=f"http://{run.host}:{run.port}")
    scene = stream.scene()
    assert scene["type"] == "scene" and scene["live"] and not scene["takes_pointer"] and scene["bodies"][0]["name"] == "peg"
    times = []
    for _ in range(60):
        stream.frame()
        times.append(time.monotonic())
    rate = (len(times) - 1) / (times[-1] - times[0])
    assert rate < 66, f"{rate} frames a second"
    stream.close()


def test_who_is_refused(run):
    token = run.token
    assert run.ask("/")[0] == 200
    assert run.ask("/nothing")[0] == 404
    assert run.ask("/../../etc/passwd")[0] == 404
    assert run.ask("/scene")[0] == 403
    assert run.ask("/scene?token=" + token)[0] == 200
    assert run.ask("/scene?token=" + token[:-1])[0] == 403
    assert run.ask("/", method="POST", Content_Length="0")[0] == 405
    assert run.ask("/", Host="evil.example:7780")[0] == 403
    assert run.ask("/scene?token=" + token, Origin="http://evil.example")[0] == 403
    assert Stream(run, path="/stream").status == 403, "no token"
    assert run.stream(Origin="http://evil.example").status == 403, "another page"
    assert run.stream(Host="evil.example").status == 403, "another name"
    assert run.stream(Sec_WebSocket_Protocol="chat").status == 426
    assert run.ask("/stream?token=" + token)[0] == 426
    assert run.ask("/" + "x" * 20000)[0] in (0, 400, 431), "a head without an end"
    for words in ("the token is missing or wrong", "is no name of this server", "not this server's own"):
        wait_for(lambda words=words: words in run.text(), f"the log has: {words}")
    still_serves(run)


def test_what_is_no_pointer(run):
    for payload, opcode in [(b"x" * 39, 2), (b"", 2), (pointer(1) + b"\0", 2), (pointer(1).replace(b"GOVP", b"GOVQ"), 2), (b"hello", 1),
                            (pointer(1, shift=(float("nan"), 0, 0)), 2)]:
        stream = run.stream()
        stream.send(payload, opcode)
        assert stream.closed() == 1008, payload
        stream.close()
    stream = run.stream()
    stream.send(pointer(1))  # well formed, but pointers are not enabled
    stream.frame()
    stream.close()
    wait_for(lambda: "a pointer message was ignored" in run.text(), "the log has the pointer")
    still_serves(run)


def test_ten_megabytes(run):
    stream = run.stream()
    try:
        stream.send(b"\0" * 10_000_000)
    except OSError:
        pass  # it was closed meanwhile
    assert stream.closed() in (0, 1009)
    wait_for(lambda: "a message of more than" in run.text(), "the log has it")
    still_serves(run)


def test_garbage(run):
    draw = random.Random(7)
    for _ in range(60):
        with run.connect() as line:
            try:
                line.sendall(draw.randbytes(draw.randrange(1, 4000)))
            except OSError:
                pass
    for _ in range(60):
        stream = run.stream()
        try:
            stream.line.sendall(draw.randbytes(draw.randrange(1, 4000)))
        except OSError:
            pass
        stream.close()
    still_serves(run)


def test_half_a_handshake(run):
    lines = [run.connect() for _ in range(20)]
    for line in lines:
        line.sendall(b"GET / HTTP/1.1\r\nHos")
    still_serves(run)
    lines[0].settimeout(12)
    assert lines[0].recv(100) == b"", "closed after its time"
    for line in lines:
        line.close()


def test_a_thousand_connections(run):
    lines = []
    for _ in range(1000):
        try:
            lines.append(run.connect())
        except OSError:
            break
    assert len(lines) > 900
    still_serves(run)
    for line in lines:
        line.close()
    still_serves(run)


def test_a_flood_does_not_fill_the_console(run):
    before = len(run.raw())
    draw = random.Random(11)
    end, sent = time.monotonic() + 3, 0
    while time.monotonic() < end:
        with run.connect() as line:
            words = bytes(draw.choice((0x1B, 0x9B, 0x85, 0xC2, 0x41, 0x42)) for _ in range(3000))
            head = (b"GET /" + words, b"BREW / HTTP/1.1\r\nHost: " + words, b"GET / HTTP/1.1\r\nHost: x\r\nOrigin: " + words)[sent % 3]
            try:
                line.sendall(head + b"\r\n\r\n")
                line.recv(100)
            except OSError:
                pass
        sent += 1
    time.sleep(0.3)
    text = run.raw()[before:]
    assert sent > 100
    assert len(text) < 20_000, f"{len(text)} bytes for {sent} requests"
    views = [line for line in text.split(b"\n") if line.startswith(b"view:")]
    for line in views:
        assert len(line) < 250 and all(0x20 <= byte < 0x7F for byte in line), line
    still_serves(run)


def statistics_with(clients):
    """Returns the report of a run of 3 s with this number of clients; if there are several, one reads no data."""
    with ViewedRun(ARGS.program, "run", "sim/scenes/grasper.toml", "--view", "--duration", "4", "--report", "/tmp/godobject-view-report.json") as run:
        streams = [Stream(run, receive_buffer=2048 if i == 0 and clients > 1 else None) for i in range(clients)]
        assert all(stream.status == 101 for stream in streams)

        def look(stream):
            try:
                while True:
                    stream.message()
            except OSError:
                pass

        threads = [threading.Thread(target=look, args=(stream,)) for stream in streams[1 if clients > 1 else 0:]]
        for thread in threads:
            thread.start()
        run.process.wait(60)
        assert run.process.returncode in (0, 1), run.text()
        for stream in streams:
            stream.close()
        for thread in threads:
            thread.join()
    with open("/tmp/godobject-view-report.json", encoding="utf-8") as file:
        report = json.load(file)
    os.remove("/tmp/godobject-view-report.json")
    return report


def test_the_loop_does_not_know_of_onlookers():
    for clients in (0, 1, 20):
        report = statistics_with(clients)
        names = [fault["name"] for fault in report["faults"]]
        step = report["timing"]["stages_us"]["step"]
        print(f"  {clients:2} clients: step p50 {step['p50']:.1f} us, p99 {step['p99']:.1f} us, faults {names}")
        assert report["cycles"] == 4000, report["cycles"]


def test_the_run_says_its_farewell():
    with ViewedRun(ARGS.program, "run", "sim/scenes/wall.toml", "--view", "--duration", "1.5") as run:
        stream = run.stream()
        assert stream.closed() == 1001, "going away"
        assert run.process.wait(30) in (0, 1)  # 1: a machine so busy that deadlines are missed


def test_wrong_options():
    for options, word in ((["--view-input"], "--view"), (["--view", "70000"], "not a port number"), (["--view", "--view-input", "--fast"], "--fast"),
                          (["--view", "--view-input", "--bus", "sim"], "--bus"), (["--view", "--view-address", "here"], "no address")):
        result = subprocess.run([ARGS.program, "run", "sim/scenes/wall.toml", *options, "--duration", "1"], cwd=SOURCE, capture_output=True,
                                text=True, timeout=60, check=False)
        assert result.returncode in (2, 3) and word in result.stderr, (options, result.returncode, result.stderr)


def test_a_port_that_is_taken():
    with ViewedRun(ARGS.program, *WALL) as first, ViewedRun(ARGS.program, *WALL) as second:
        assert first.port != second.port, "the next free one"
        with socket.socket() as taken:
            taken.bind(("127.0.0.1", 0))
            taken.listen()
            result = subprocess.run([ARGS.program, "run", "sim/scenes/wall.toml", "--view", str(taken.getsockname()[1]), "--duration", "1"],
                                    cwd=SOURCE, capture_output=True, text=True, timeout=60, check=False)
            assert result.returncode == 3 and "Give another port" in result.stderr, result.stderr


def main():
    with ViewedRun(ARGS.program, *WALL) as run:
        for test in share((test_a_stream, test_who_is_refused, test_what_is_no_pointer, test_ten_megabytes, test_garbage, test_half_a_handshake,
                     test_a_thousand_connections, test_a_flood_does_not_fill_the_console)):
            print(test.__name__)
            test(run)
    for test in share((test_wrong_options, test_the_run_says_its_farewell, test_a_port_that_is_taken, test_the_loop_does_not_know_of_onlookers)):
        print(test.__name__)
        test()


main()
