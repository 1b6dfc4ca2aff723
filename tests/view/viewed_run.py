"""A running `godobject run --view` and clients of it without libraries, for the tests in this folder."""
import argparse
import base64
import json
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time

SKIPPED = 77
SOURCE = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))


def arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    return parser.parse_args()


def share(tests):
    """Every k-th test where k, GTEST_TOTAL_SHARDS, is in the environment, as in `./dev test`; else all."""
    return tests[::int(os.environ.get("GTEST_TOTAL_SHARDS", "1"))]


def skip(why):
    print("skipped:", why)
    sys.exit(SKIPPED)


class ViewedRun:
    """Runs the program with these arguments in the source directory; the end of `with` stops it by SIGINT."""

    def __init__(self, program, *args, folder=None):
        self.folder = folder or tempfile.mkdtemp(prefix="godobject-view-")
        environment = dict(os.environ, XDG_RUNTIME_DIR=self.folder)  # uses the token of this folder
        self.log_path = os.path.join(self.folder, f"log-{time.monotonic_ns()}")
        self.log = open(self.log_path, "wb")
        self.process = subprocess.Popen([program, *args], cwd=SOURCE, env=environment, stdout=self.log, stderr=self.log)
        for _ in range(300):
            found = re.search(r"(http://(\S+?):(\d+)/\?token=(\w+))", self.text())
            if found:
                self.url, self.host, self.port, self.token = found[1], found[2], int(found[3]), found[4]
                return
            if self.process.poll() is not None:
                break
            time.sleep(0.1)
        self.process.kill()
        raise AssertionError("no address was printed:\n" + self.text())

    def raw(self):
        with open(self.log_path, "rb") as file:
            return file.read()

    def text(self):
        return self.raw().decode(errors="replace")

    def end(self, by=signal.SIGINT, patience=30):
        if self.process.poll() is None:
            self.process.send_signal(by)
        self.process.wait(patience)
        return self.process.returncode

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.end()
        self.log.close()

    def connect(self, patience=10):
        return socket.create_connection((self.host, self.port), patience)

    def ask(self, path, method="GET", **headers):
        """Returns the status and the body of an answer."""
        with self.connect() as line:
            heads = {"Host": f"{self.host}:{self.port}", "Connection": "close", **{k.replace("_", "-"): v for k, v in headers.items()}}
            line.sendall((f"{method} {path} HTTP/1.1\r\n" + "".join(f"{k}: {v}\r\n" for k, v in heads.items()) + "\r\n").encode())
            answer = b""
            try:
                while part := line.recv(65536):
                    answer += part
            except ConnectionResetError:
                pass  # closed by the server, with unread data
        head, _, body = answer.partition(b"\r\n\r\n")
        return int(head.split()[1]) if head else 0, body

    def stream(self, **headers):
        return Stream(self, **headers)


class Stream:
    """A WebSocket to a run; `status` is 101 if it was accepted."""

    def __init__(self, run, path=None, receive_buffer=None, **headers):
        self.line = socket.socket()
        if receive_buffer:
            self.line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.line.settimeout(10)
        self.line.connect((run.host, run.port))
        heads = {"Host": f"{run.host}:{run.port}", "Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13",
                 "Sec-WebSocket-Key": base64.b64encode(os.urandom(16)).decode(), "Sec-WebSocket-Protocol": "godobject.view.v1"}
        heads.update({k.replace("_", "-"): v for k, v in headers.items()})
        path = path or f"/stream?token={run.token}"
        self.line.sendall((f"GET {path} HTTP/1.1\r\n" + "".join(f"{k}: {v}\r\n" for k, v in heads.items()) + "\r\n").encode())
        self.rest = b""
        while b"\r\n\r\n" not in self.rest:
            part = self.line.recv(65536)
            if not part:
                break
            self.rest += part
        head, _, self.rest = self.rest.partition(b"\r\n\r\n")
        self.status = int(head.split()[1]) if head else 0

    def bytes(self, n):
        while len(self.rest) < n:
            part = self.line.recv(65536)
            if not part:
                raise ConnectionError("closed")
            self.rest += part
        taken, self.rest = self.rest[:n], self.rest[n:]
        return taken

    def message(self):
        """Returns opcode (1 text, 2 binary, 8 close, 9 ping) and payload."""
        first, second = self.bytes(2)
        size = second & 127
        if size == 126:
            size, = struct.unpack(">H", self.bytes(2))
        elif size == 127:
            size, = struct.unpack(">Q", self.bytes(8))
        return first & 15, self.bytes(size)

    def send(self, payload, opcode=2):
        mask = os.urandom(4)
        size = len(payload)
        head = bytes([0x80 | opcode]) + (bytes([0x80 | size]) if size < 126 else
                                         bytes([0x80 | 126]) + struct.pack(">H", size) if size < 65536 else bytes([0x80 | 127]) + struct.pack(">Q", size))
        masked = bytes(b ^ mask[i % 4] for i, b in enumerate(payload)) if size < 100000 else payload
        self.line.sendall(head + (mask if size < 100000 else b"\0\0\0\0") + masked)

    def scene(self):
        opcode, payload = self.message()
        assert opcode == 1, opcode
        return json.loads(payload)

    def frame(self):
        """Returns the next frame as a dictionary of its tested fields."""
        while True:
            opcode, payload = self.message()
            if opcode == 2:
                return decode_frame(payload)

    def closed(self):
        """Returns the code of the close message, or 0 if the connection ends without."""
        try:
            while True:
                opcode, payload = self.message()
                if opcode == 8:
                    return struct.unpack(">H", payload[:2])[0]
        except (ConnectionError, OSError):
            return 0

    def close(self):
        self.line.close()


def decode_frame(data):
    magic, version, header, cycle, t, phase, flags, num_driven, fault, limited, rig_fault, held, num_bodies, num_contacts, num_vertices = \
        struct.unpack_from("<IHHQdBBHIIIiIII", data)
    num_values, = struct.unpack_from("<I", data, 120)
    assert magic == 0x46564F47 and version == 1 and header == 132, data[:8]
    assert len(data) == 132 + 28 * num_bodies + 76 * num_driven + 44 * num_contacts + 12 * num_vertices + 4 * num_values
    bodies = [struct.unpack_from("<7f", data, 132 + 28 * i) for i in range(num_bodies)]
    driven = [struct.unpack_from("<19f", data, 132 + 28 * num_bodies + 76 * i) for i in range(num_driven)]
    return {"cycle": cycle, "t": t, "phase": phase, "flags": flags, "fault": fault, "limited": limited, "rig_fault": rig_fault, "held": held,
            "bodies": bodies, "targets": [d[:7] for d in driven], "num_contacts": num_contacts}


def pointer(number, holds=True, moves=True, target=0, shift=(0, 0, 0), turn=(0, 0, 0)):
    return struct.pack("<IHHII6f", 0x50564F47, 1, (1 if holds else 0) | (2 if moves else 0), number, target, *shift, *turn)
