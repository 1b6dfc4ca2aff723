#!/usr/bin/env python3
"""Runs docs/examples/microcontroller/bus_follower.cc in QEMU, its UART on the pseudo-terminal of a simulated rig: frames of the
bus move its tool, and its torques arrive at the drive. Exit status 77: skipped, a package is missing.

usage: bus_follower.py SOURCE_DIR WORK_DIR GODOBJECT
"""
import pathlib
import statistics
import subprocess
import sys
import tempfile

import cortex_m7

END_S = 120  # of a busy machine; 3 s on an idle one
WEIGHT = 0.2 * 9.81  # N, of the tool
STIFFNESS = 500  # N/m, of its coupling and of the feedback
M_PER_MOTOR_RAD = 0.02


def check(lines, torques_Nm, status):
    """Returns complaints. lines: of the firmware; torques_Nm: commanded on the bus; status: of the simulated rig at the end."""
    failed = []
    rows = [[float(word) for word in line.split(",")[1:]] for line in lines if line.startswith("sample,")]
    late = rows[len(rows) // 2:]  # after the ramp of 0.5 s
    positions = [row[0] for row in rows]
    if not late or max(positions) - min(positions) < 0.01:
        return ["the bus has not moved the target by 10 mm"]
    if sum(row[3] for row in late) < len(late) / 2:
        failed.append("the drive was not enabled")
    # Medians, because on a busy machine cycles are held up, and the drive's watchdog may trip.
    sag, force = (statistics.median(values) for values in zip(*((row[0] - row[1], row[2]) for row in late)))
    if abs(sag - WEIGHT / STIFFNESS) > 5e-4:
        failed.append(f"the tool hangs {1e3 * sag:.2f} mm below its target, not {1e3 * WEIGHT / STIFFNESS:.2f}")
    if abs(force + WEIGHT) > 0.1 * WEIGHT:
        failed.append(f"the force is {force:.3f} N, the tool weighs {WEIGHT:.3f} N")
    expected = -WEIGHT * M_PER_MOTOR_RAD
    commanded = statistics.median(torques_Nm[len(torques_Nm) // 2:] or [0])
    if abs(commanded - expected) > 0.1 * abs(expected):
        failed.append(f"torques of {commanded:.4f} N m on the bus, not of {expected:.4f}")
    if not status["drives"][0]["max_torque_Nm"] > 0.5 * abs(expected):
        failed.append("the drive had no torque")
    return failed


def check_rules():
    """The check itself must refuse."""
    good = ["sample,%.4f,%.4f,-1.96,1" % (z, z - 0.00392) for z in (0, 0.01, 0.02, 0.02, 0.01, 0.0)]
    had = {"drives": [{"max_torque_Nm": 0.04}]}
    assert not check(good, [-0.039], had)
    assert check([], [-0.039], had) and check(good, [], had) and check(good, [0.0], had)
    assert check(good, [-0.039], {"drives": [{"max_torque_Nm": 0.0}]})
    assert check([line.replace("-1.96", "0.0") for line in good], [-0.039], had)
    assert check([line.replace(",1", ",0") for line in good], [-0.039], had)
    assert check(["sample,0.0,-0.00392,-1.96,1"] * 6, [-0.039], had)


def main():
    check_rules()
    source, work, program = sys.argv[1:4]
    source, work = pathlib.Path(source), pathlib.Path(work)
    if cortex_m7.missing():
        print(f"skipped: install {' '.join(cortex_m7.missing())} (./dev setup arm)")
        return 77
    sys.path.insert(0, str(source / "platform/python"))
    from godobject import hil  # noqa: PLC0415, of the source tree
    image = cortex_m7.build(source, work, "double", "cortex-m7.cmake", ["bus-follower"]) / "bus-follower.elf"
    with (hil.Rig(source / "docs/examples/microcontroller/bus-follower.toml", program=program) as rig,
          tempfile.TemporaryFile("w+") as output):
        uart = ["-chardev", f"serial,id=uart,path={rig.terminal()}", "-serial", "chardev:uart"]
        exit_code = rig.start([*cortex_m7.BOARD, *uart, "-kernel", image], stdout=output).wait(END_S)
        output.seek(0)
        lines = output.read().splitlines()
        status = rig.status()
        commands = [message for message in map(rig.scene.decode, rig.bus.frames) if message.name.endswith("torque command")]
    print("\n".join(lines))
    failed = check(lines, [message.values["torque_Nm"] for message in commands], status)
    if exit_code != 0:
        failed.append(f"exit code {exit_code}")
    print(f"{len(commands)} torques on the bus, up to {status['drives'][0]['max_torque_Nm']:.4f} N m at the drive")
    silent = subprocess.run([str(word) for word in [*cortex_m7.BOARD, "-serial", "null", "-kernel", image]], capture_output=True,
                            text=True, timeout=END_S)
    if silent.returncode != 1 or "# 0 samples" not in silent.stdout:
        failed.append(f"without a rig: exit code {silent.returncode}, not 1: {silent.stdout}")
    print("\n".join(failed))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
