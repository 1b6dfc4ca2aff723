#!/usr/bin/env python3
"""Builds docs/examples/microcontroller for a Cortex-M7 and for the host, runs it in QEMU, and compares the traces. Checks the
size of the smallest firmware, and that a firmware that allocates does not link. Exit status 77: skipped, a package is missing.

usage: cortex_m7.py SOURCE_DIR WORK_DIR
"""
import pathlib
import re
import shutil
import subprocess
import sys

PACKAGES = {"arm-none-eabi-g++": "gcc-arm-none-eabi", "qemu-system-arm": "qemu-system-arm"}
FILES = {"/usr/include/newlib/stdint.h": "libnewlib-arm-none-eabi", "/usr/include/newlib/c++": "libstdc++-arm-none-eabi-dev"}
TOLERANCE = 1e-9  # m, and of components of the quaternion; printed with 12 decimals
FLOAT_TOLERANCE = 1e-5
NUM_STEPS, PRINTED_EVERY = 2000, 50
BODIES = {"rigid": 1, "grasper": 4, "press": 1}
MAX_FLASH, MAX_RAM = 16 * 1024, 1024  # bytes of follower.elf, without the stack
MAX_REFERENCE_ERROR = 1e-6  # m, of `grasper` and `press` against the reference solution; tests/core bounds the method itself
REFUSED = re.compile(r"\b(_?malloc(_r)?|_sbrk(_r)?|_free_r|_Znwj|_Znaj|__cxa_throw|_Unwind_\w+|printf)$", re.M)
# 64 ns of virtual time per instruction, see board.h
QEMU = ["qemu-system-arm", "-M", "mps2-an500", "-nographic", "-monitor", "none", "-serial", "none", "-icount", "shift=6",
        "-chardev", "stdio,id=out", "-semihosting-config", "enable=on,target=native,chardev=out", "-kernel"]


def run(*command, check=True):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=600)
    if check and done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: status {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-6000:]}")
    return done


def missing():
    return ([package for program, package in PACKAGES.items() if not shutil.which(program)]
            + [package for file, package in FILES.items() if not pathlib.Path(file).exists()])


def rows_of(trace):
    """Rows of a trace by step and body, and its line of totals."""
    lines = trace.splitlines()
    rows = {tuple(map(int, line.split(",")[:2])): [float(a) for a in line.split(",")[2:]] for line in lines if line[:1].isdigit()}
    return rows, lines[-1]


def flash_and_ram(image):
    """Bytes of an image in the flash, and of its data without the stack."""
    text, data, bss = map(int, run("arm-none-eabi-size", image).stdout.splitlines()[1].split()[:3])
    return text + data, data + bss


def largest_difference(a, b):
    """Largest difference of two traces; infinite if they differ in their rows."""
    if a.keys() != b.keys() or not a:
        return float("inf")
    return max(abs(x - y) for key in a for x, y in zip(a[key], b[key], strict=True))


def reference_error(rows, folder):
    """Largest error of a position against a reference case, m."""
    lines = [line.split(",") for line in (folder / "reference.csv").read_text().split()]
    names = [column[:-2] for column in lines[0] if column.endswith(".x")]
    at = {round(1000 * float(line[0])): dict(zip(lines[0], map(float, line))) for line in lines[1:]}
    return max(abs(rows[step, body][i] - at[step][f"{names[body]}.{axis}"])
               for step, body in rows for i, axis in enumerate("xyz"))


def check_comparison():
    """The comparison itself must refuse."""
    a = {(50, 0): [0.1, 0.2]}
    assert largest_difference(a, a) == 0 and largest_difference(a, {(50, 0): [0.1, 0.2 + 2 * TOLERANCE]}) > TOLERANCE
    assert largest_difference(a, {}) == largest_difference({}, {}) == float("inf")
    assert REFUSED.search("00000000 T _malloc_r\n") and not REFUSED.search("00000000 T memcpy\n")


def main():
    source, work = map(pathlib.Path, sys.argv[1:3])
    check_comparison()
    if missing():
        print(f"skipped: install {' '.join(missing())} (./dev setup arm)")
        return 77
    example = source / "docs/examples/microcontroller"
    cache = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    m7 = ["--toolchain", example / "cortex-m7.cmake"]
    for target, options, programs in (("m7", m7, ["all"]), ("float", ["-DREAL=float", *m7], ["trace-rigid", "follower"]), ("host", [], ["all"])):
        run("cmake", "-S", example, "-B", work / target, f"-Dgodobject_DIR={source}/tests/freestanding/from_tree", *cache, *options)
        run("cmake", "--build", work / target, "--parallel", 2, "--target", *programs)

    failed = []
    for scene, num_bodies in BODIES.items():
        emulated, totals = rows_of(run(*QEMU, work / f"m7/trace-{scene}.elf").stdout)
        on_host, _ = rows_of(run(work / f"host/trace-{scene}").stdout)
        difference = largest_difference(emulated, on_host)
        steps, instructions, most, stack, memory = map(int, re.findall(r"\d+", totals))
        print(f"{scene}: {steps} steps, trace {difference:.1e} from the host's, {instructions} instructions per step (most {most}), "
              f"flash {flash_and_ram(work / f'm7/trace-{scene}.elf')[0]} B, RAM {memory} B, stack {stack} B")
        if len(emulated) != num_bodies * NUM_STEPS // PRINTED_EVERY or steps != NUM_STEPS or not difference <= TOLERANCE:
            failed.append(f"{scene}: the traces differ")
        if not 100 < instructions <= most < 1_000_000 or not 100 < stack:
            failed.append(f"{scene}: the counters are wrong")
        reference = source.parent / "shared/reference" / scene
        if reference.exists():
            error = reference_error(emulated, reference)
            print(f"{scene}: {error:.1e} m from the reference solution")
            if not error <= MAX_REFERENCE_ERROR:
                failed.append(f"{scene}: another scene than the reference case")

    firmware = work / "m7/follower.elf"
    flash, ram = flash_and_ram(firmware)
    print(f"follower: {flash} B of flash, {ram} B of RAM without the stack")
    if flash > MAX_FLASH or ram > MAX_RAM:
        failed.append(f"follower: more than {MAX_FLASH} B of flash or {MAX_RAM} B of RAM")
    run(*QEMU, firmware)
    flash, ram = flash_and_ram(work / "float/follower.elf")
    emulated, totals = rows_of(run(*QEMU, work / "float/trace-rigid.elf").stdout)
    on_host, _ = rows_of(run(work / "host/trace-rigid").stdout)
    difference = largest_difference(emulated, on_host)
    print(f"float: rigid {difference:.1e} from double, {totals[2:]}; follower {flash} B of flash, {ram} B of RAM")
    if not TOLERANCE < difference <= FLOAT_TOLERANCE:
        failed.append("float: rigid is not that of double, or not of float")
    for image in sorted((work / "m7").glob("*.elf")):
        failed += [f"{image.name}: {found[0]}" for found in REFUSED.finditer(run("arm-none-eabi-nm", image).stdout)]

    # A firmware that allocates must not link.
    hoarding = run("arm-none-eabi-g++", "-mthumb", "-mcpu=cortex-m7", "-mfloat-abi=hard", "-mfpu=fpv5-d16", "-nostdlib", "-T",
                   example / "mps2-an500.ld", source / "tests/freestanding/not_freestanding.cc", "-o", work / "hoarding.elf",
                   "-Wl,--undefined=_Z5hoardd", "-lm", "-lc_nano", "-lgcc", check=False)
    if hoarding.returncode == 0 or "operator new" not in hoarding.stderr:
        failed.append("a firmware that allocates links")
    print("\n".join(failed))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
