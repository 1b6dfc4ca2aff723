#!/usr/bin/env python3
"""A sealed run beside a stalled disk and stopped readers: no system call is refused, no page faults, the deadlines are
kept, and the lost lines are counted.

usage: test_stalls.py --program PATH
"""
import json
import os
import re
import signal
import socket
import subprocess
import tempfile
import time

from viewed_run import Stream, ViewedRun, arguments, skip

ARGS = arguments()
ATTEMPTS = 10  # of a run that a busy machine has held
SECONDS = 3
STALL_AFTER_S = 1
NIGHTLY = "GODOBJECT_NIGHTLY" in os.environ


class Reader:
    """Copies a FIFO into a file, in a process of its own. Stopped, it is a disk that stalls for the FIFO's writer."""

    def __init__(self, folder, name):
        self.fifo = os.path.join(folder, name)
        self.copy = self.fifo + ".copy"
        os.mkfifo(self.fifo)
        with open(self.copy, "wb") as out:
            self.process = subprocess.Popen(["cat", self.fifo], stdout=out)

    def stop(self):
        self.process.send_signal(signal.SIGSTOP)

    def rest(self):
        """Reads what is left in the FIFO of an ended writer. Returns the whole text."""
        self.process.send_signal(signal.SIGCONT)
        self.process.wait(10)
        with open(self.copy, encoding="ascii") as file:
            return file.read()


def free_port():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return taken.getsockname()[1]


def run_beside(stalls):
    """Returns report, console and the texts of trace and record of a run. stalls: if all readers stop during the run."""
    port = free_port()
    with tempfile.TemporaryDirectory(prefix="godobject-stalls-") as folder:
        trace, record = Reader(folder, "trace.csv"), Reader(folder, "bus.log")
        path = os.path.join(folder, "report.json")
        with ViewedRun(ARGS.program, "run", "sim/scenes/grasper.toml", "--duration", str(SECONDS), "--seal", "--view",
                       "--openigtlink", str(port), "--openigtlink-rate", "1000", "--trace", trace.fifo, "--record", record.fifo,
                       "--report", path, folder=folder) as run:
            clients = [run.stream() if not stalls else Stream(run, receive_buffer=4096), socket.create_connection((run.host, port), 10)]
            clients[0].scene()  # from now on neither client reads
            if stalls:
                time.sleep(STALL_AFTER_S)
                trace.stop()
                record.stop()
            run.process.wait(60)
            for client in clients:
                client.close()
            with open(path, encoding="utf-8") as file:
                return json.load(file), run.text(), trace.rest(), record.rest()


def lost_lines(report, name):
    """Returns the number of lines that a fault of the report counts as lost for a file."""
    return sum(int(re.search(r"lacks (\d+)", fault["text"])[1]) for fault in report["faults"]
               if fault["name"] in ("file_incomplete", "records_lost") and name in fault["text"])


def expect_undisturbed(report, console):
    assert report["seal"] == {"broken_by": None, "refused_calls": 0}, report["seal"]
    if any(step["step"] == "lock memory" and step["result"] == "ok" for step in report["machine"]["rt_setup"]):
        assert report["page_faults"] == {"minor": 0, "major": 0, "first_cycle": None}, report["page_faults"]
    assert report["cycles"] == 1000 * SECONDS, report["cycles"]
    others = [fault for fault in report["faults"] if fault["name"] not in ("file_incomplete", "records_lost")]
    assert not others, (others, console)


def test_stalls_cost_lines_alone():
    for stalls in (False, True) if NIGHTLY else (True,):  # also without, for comparison
        for _ in range(ATTEMPTS):
            report, console, trace, record = run_beside(stalls)
            if "deadlines" not in report["limits"]:
                break
        missed, lost = report["timing"]["missed_deadlines"], [lost_lines(report, name) for name in ("trace.csv", "bus.log")]
        print(f"  readers {'stop' if stalls else 'go on'}: {missed} deadlines missed; lost: {lost} lines of trace and record")
        assert "deadlines" not in report["limits"], (report["limits"], console)
        expect_undisturbed(report, console)
        rows = trace.splitlines()
        complete = rows if trace.endswith("\n") else rows[:-1]
        # Lines of a write that has not returned count as lost. Some of them may be in the FIFO.
        unknown = 65536 * len(rows) // len(trace) + 1
        counted = len(complete) + lost[0] - (report["cycles"] + 2)  # head, start, and a row a cycle
        assert -1 <= counted <= unknown, (len(rows), lost)
        times = [float(row.split(",")[0]) for row in complete[1:]]
        assert all(abs(b - a - 1e-3) < 1e-6 for a, b in zip(times, times[1:])), "no row before the last is missing"
        if not stalls:
            assert lost == [0, 0], lost
            continue
        assert min(lost) > 0 and len(complete) > 1000 * STALL_AFTER_S / 3, (lost, len(complete))
        assert record, "the frames before the stall are there"
        for count in lost:
            assert f"lacks {count} lines" in console, (count, console)


def main():
    try:
        test_stalls_cost_lines_alone()
    except AssertionError as error:
        if "--seal:" in str(error):
            skip(str(error))
        raise


main()
