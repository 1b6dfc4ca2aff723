#!/usr/bin/env python3
"""Checks that clang's proof of the cycle reaches each of its stages: it plants an allocation in one function of each,
and the proof must name every one of them.

usage: plant_in_cycle.py SOURCE -- PROVER ARGUMENT...
"""
import pathlib
import re
import subprocess
import sys
import tempfile

# stage of the cycle, file, function
PLANTS = [
    ("cycle", "platform/cli/run/loop.h", "bool operator()(const Wake& wake) noexcept GODOBJECT_NONBLOCKING {"),
    ("receive", "hal/rig/receive.cc", "void Rig::receive(Nanoseconds now) noexcept {"),
    ("receive, SLCAN", "platform/linux/bus/slcan.cc", "bool SlcanBus::try_receive(ReceivedFrame& out) noexcept {"),
    ("receive, SocketCAN", "platform/linux/bus/socket_can.cc", "bool SocketCanBus::try_receive(ReceivedFrame& out) noexcept {"),
    ("decode, CiA 402", "hal/drive/cia402_link.cc",
     "DriveMessage Cia402Link::decode(const CanFrame& frame, DriveTelemetry& out) noexcept {"),
    ("decode, ODrive", "hal/drive/odrive.cc", "DriveMessage OdriveLink::decode(const CanFrame& frame, DriveTelemetry& out) noexcept {"),
    ("decode, moteus", "hal/drive/moteus.cc", "DriveMessage MoteusLink::decode(const CanFrame& frame, DriveTelemetry& out) noexcept {"),
    ("decode, encoder", "hal/rig/receive.cc",
     "void Rig::on_position(RigNode& node, const CanFrame& frame, const SyncAttribution::Answer& answer) noexcept {"),
    ("supervise", "hal/rig/supervise.cc", "void Rig::supervise(Nanoseconds now) noexcept {"),
    ("limit", "hal/drive/drive.cc", "DriveCommand Drive::plan(double tau_joint, DriveGoal goal, Nanoseconds now) noexcept {"),
    ("encode, CiA 402", "hal/drive/cia402_link.cc",
     "DriveFrame Cia402Link::command(const DriveOrder& order, Nanoseconds now) const noexcept {"),
    ("encode, ODrive", "hal/drive/odrive.cc", "DriveFrame OdriveLink::command(const DriveOrder& order, Nanoseconds now) const noexcept {"),
    ("encode, moteus", "hal/drive/moteus.cc", "DriveFrame MoteusLink::command(const DriveOrder& order, Nanoseconds) const noexcept {"),
    ("send", "hal/rig/rig.cc", "bool Rig::send(std::size_t bus, const CanFrame& frame) noexcept {"),
    ("send, SLCAN", "platform/linux/bus/slcan.cc", "SendResult SlcanBus::try_send(const CanFrame& frame) noexcept {"),
    ("send, SocketCAN", "platform/linux/bus/socket_can.cc", "SendResult SocketCanBus::try_send(const CanFrame& frame) noexcept {"),
    ("session", "platform/session/session.cc", "void Session::command("),
]
CALL = "delete new int;"


def planted(text, function, file):
    """Returns the text with the call at the beginning of the function."""
    at = text.find(function)
    if at < 0 or text.find(function, at + 1) >= 0:
        sys.exit(f"{file}: {'no' if at < 0 else 'more than one'} function begins with '{function}': change PLANTS of plant_in_cycle.py")
    brace = text.index("{\n", at) + 2
    return f"{text[:brace]}{CALL}\n{text[brace:]}"


def main():
    source, command = pathlib.Path(sys.argv[1]), sys.argv[3:]
    texts = {file: (source / file).read_text() for _, file, _ in PLANTS}
    for stage, file, function in PLANTS:
        texts[file] = planted(texts[file], function, file)
    with tempfile.TemporaryDirectory() as folder:
        for file, text in texts.items():
            copy = pathlib.Path(folder, file)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_text(text)
        proof = subprocess.run([*command[:1], "-I", folder, *command[1:], "-ferror-limit=0"], capture_output=True, text=True)
    named = set(re.findall(rf"{re.escape(folder)}/(\S+?):(\d+):\d+: ", proof.stderr))
    missed = 0
    for stage, file, function in PLANTS:
        lines = texts[file].splitlines()
        head = next(i for i, line in enumerate(lines) if function in line)
        line = next(i for i in range(head, len(lines)) if lines[i] == CALL) + 1
        found = (file, str(line)) in named
        print(f"{stage}: {'named' if found else 'NOT NAMED: the proof does not reach it'}")
        missed += not found
    if missed == len(PLANTS):
        print(proof.stderr[-2000:])
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
