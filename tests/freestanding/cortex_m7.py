#!/usr/bin/env python3
"""Builds docs/examples/microcontroller for a Cortex-M7 and for the host, with double and with float, runs it in QEMU, and
compares the traces. Checks the size of the smallest firmware, its stack, the table of the example's page, and that a firmware
that allocates does not link. Exit status 77: skipped, a package is missing.

usage: cortex_m7.py [--write] SOURCE_DIR WORK_DIR

--write: writes the table instead of checking it.
"""
import pathlib
import re
import shutil
import subprocess
import sys

PACKAGES = {"arm-none-eabi-g++": "gcc-arm-none-eabi", "qemu-system-arm": "qemu-system-arm"}
FILES = {"/usr/include/newlib/stdint.h": "libnewlib-arm-none-eabi", "/usr/include/newlib/c++": "libstdc++-arm-none-eabi-dev"}
REALS = ("double", "float")
NUM_STEPS, PRINTED_EVERY = 2000, 50
BODIES = {"rigid": 1, "grasper": 4, "press": 1}
EMULATED = {"double": tuple(BODIES), "float": ("rigid",)}
TOLERANCE = {"double": 1e-9, "float": 1e-5}  # of the emulated trace from the host's, m, and of components of the quaternion
FLOAT_TOLERANCE = {"rigid": 3e-6, "grasper": 1.5e-5, "press": 3e-7}  # likewise, of float from double on the host
MAX_FLASH, MAX_STATIC = 16 * 1024, 1024  # bytes of follower.elf, without the stack
MAX_RAM = {"double": 3840, "float": 1920}  # bytes of static RAM and stack
MAX_REFERENCE_ERROR = 1e-6  # m, of `grasper` and `press` against the reference solution; tests/core bounds the method itself
TABLE_TOLERANCE = 0.05  # share by which numbers of the page's table may be off
BEGIN, END = "<!-- begin of the sizes -->\n", "<!-- end of the sizes -->\n"
REFUSED = re.compile(r"\b(_?malloc(_r)?|_sbrk(_r)?|_free_r|_Znwj|_Znaj|__cxa_throw|_Unwind_\w+|printf)$", re.M)
BOARD = ["qemu-system-arm", "-M", "mps2-an500", "-nographic", "-monitor", "none", "-chardev", "stdio,id=out",
         "-semihosting-config", "enable=on,target=native,chardev=out"]
# 64 ns of virtual time per instruction, see board.h
QEMU = [*BOARD, "-serial", "none", "-icount", "shift=6", "-kernel"]


def run(*command, check=True):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=600)
    if check and done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: status {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-6000:]}")
    return done


def missing():
    return ([package for program, package in PACKAGES.items() if not shutil.which(program)]
            + [package for file, package in FILES.items() if not pathlib.Path(file).exists()])


def build(source, work, real, toolchain=None, targets=("all",)):
    """Builds the example and returns the folder of its programs. toolchain: None for the host."""
    example = source / "docs/examples/microcontroller"
    folder = work / f"{'m7' if toolchain else 'host'}-{real}"
    options = [f"-DREAL={'' if real == 'double' else real}", f"-Dgodobject_DIR={source}/tests/freestanding/from_tree"]
    if shutil.which("ccache"):
        options.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
    if toolchain:
        options += ["--toolchain", example / toolchain]
    run("cmake", "-S", example, "-B", folder, *options)
    run("cmake", "--build", folder, "--parallel", 2, "--target", *targets)
    return folder


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


def off(stated, measured):
    """True if tables differ in their words, or in a number by more than TABLE_TOLERANCE, one written with e by more than twice."""
    number = re.compile(r"\d+(?: \d{3})*(?:\.\d+)?(?:e-\d+)?")
    if number.sub("#", stated) != number.sub("#", measured):
        return True
    for a, b in zip(number.findall(stated), number.findall(measured), strict=True):
        x, y = (float(text.replace(" ", "")) for text in (a, b))
        if abs(x - y) > (abs(y) if "e" in b else TABLE_TOLERANCE * abs(y)):
            return True
    return False


def grouped(number):
    return f"{number:,}".replace(",", " ")


def check_comparison():
    """The comparison itself must refuse."""
    a = {(50, 0): [0.1, 0.2]}
    assert largest_difference(a, a) == 0 and largest_difference(a, {(50, 0): [0.1, 0.2 + 2e-9]}) > 1e-9
    assert largest_difference(a, {}) == largest_difference({}, {}) == float("inf")
    assert REFUSED.search("00000000 T _malloc_r\n") and not REFUSED.search("00000000 T memcpy\n")
    assert not off("| rigid | 4 815 B | 2.0e-10 |", "| rigid | 4 900 B | 1.1e-10 |")
    assert off("| rigid | 4 815 B |", "| rigid | 5 815 B |") and off("| rigid | 1.0e-9 |", "| press | 1.0e-9 |")
    assert off("| 3.0e-10 |", "| 1.0e-10 |")


def check_float(folders):
    """Runs the traces on the host. Returns complaints, the traces by number type and scene, and the deviation of float."""
    traces = {real: {scene: rows_of(run(folders[real] / f"trace-{scene}").stdout)[0] for scene in BODIES} for real in REALS}
    failed, deviation = [], {}
    for scene, tolerance in FLOAT_TOLERANCE.items():
        deviation[scene] = largest_difference(*(traces[real][scene] for real in REALS))
        print(f"{scene}: float deviates from double by {deviation[scene]:.1e} on the host, permitted are {tolerance:g}")
        if not tolerance / 100 < deviation[scene] <= tolerance:
            failed.append(f"{scene}: float is not that of double, or not of float")
    return failed, traces, deviation


def check_scene(real, scene, folder, on_host, source):
    """Returns complaints about an emulated trace, and its cells of the table."""
    failed = []
    image = folder / f"trace-{scene}.elf"
    emulated, totals = rows_of(run(*QEMU, image).stdout)
    difference = largest_difference(emulated, on_host)
    steps, instructions, most, stack, memory = map(int, re.findall(r"\d+", totals))
    flash, _ = flash_and_ram(image)
    print(f"{scene}, {real}: {steps} steps, trace {difference:.1e} from the host's, {instructions} instructions per step (most "
          f"{most}), flash {flash} B, data {memory} B, stack {stack} B")
    if len(emulated) != BODIES[scene] * NUM_STEPS // PRINTED_EVERY or steps != NUM_STEPS or not difference <= TOLERANCE[real]:
        failed.append(f"{scene}, {real}: the traces differ")
    if not 100 < instructions <= most < 1_000_000 or not 100 < stack:
        failed.append(f"{scene}, {real}: the counters are wrong")
    reference = source.parent / "shared/reference" / scene
    if real == "double" and reference.exists():
        error = reference_error(emulated, reference)
        print(f"{scene}: {error:.1e} m from the reference solution")
        if not error <= MAX_REFERENCE_ERROR:
            failed.append(f"{scene}: another scene than the reference case")
    return failed, [f"`{scene}`, {real}", grouped(instructions), f"{grouped(flash)} B", f"{grouped(memory)} B", f"{grouped(stack)} B"]


def check_follower(real, folder):
    """Returns complaints about the smallest firmware, and its cells of the table."""
    failed = []
    flash, static = flash_and_ram(folder / "follower.elf")
    run(*QEMU, folder / "follower.elf")
    stack = int(re.search(r"# stack (\d+) B", run(*QEMU, folder / "follower-stack.elf").stdout)[1])
    print(f"follower, {real}: {flash} B of flash (permitted {MAX_FLASH}), {static} B of static RAM (permitted {MAX_STATIC}) and "
          f"{stack} B of stack: {static + stack} B of RAM (permitted {MAX_RAM[real]})")
    if flash > MAX_FLASH or static > MAX_STATIC or static + stack > MAX_RAM[real] or stack < 100:
        failed.append(f"follower, {real}: more than {MAX_FLASH} B of flash, {MAX_STATIC} B of static RAM or {MAX_RAM[real]} B of RAM")
    return failed, [f"`follower`, {real}", "-", f"{grouped(flash)} B", f"{grouped(static)} B", f"{grouped(stack)} B"]


def table_of(rows, deviation):
    """The part of the example's page between BEGIN and END."""
    lines = ["| image, numbers | instructions per step | flash | static RAM | stack |", "|---|---|---|---|---|"]
    lines += [f"| {' | '.join(cells)} |" for cells in rows]
    of_float = ", ".join(f"`{scene}` {difference:.1e}" for scene, difference in deviation.items())
    return "\n".join(lines) + f"\n\nFloat differs from double on the host by at most: {of_float} (m, components of quaternions).\n"


def main():
    arguments = [a for a in sys.argv[1:] if a != "--write"]
    source, work = map(pathlib.Path, arguments)
    check_comparison()
    failed, traces, deviation = check_float({real: build(source, work, real) for real in REALS})
    if missing():
        print("\n".join(failed))
        print(f"skipped: install {' '.join(missing())} (./dev setup arm)")
        return 1 if failed else 77

    example = source / "docs/examples/microcontroller"
    rows = []
    for real in REALS:
        targets = [f"trace-{scene}" for scene in EMULATED[real]] + ["follower", "follower-stack"]
        folder = build(source, work, real, "cortex-m7.cmake", targets)
        for complaints, cells in [*(check_scene(real, scene, folder, traces[real][scene], source) for scene in EMULATED[real]),
                                  check_follower(real, folder)]:
            failed += complaints
            rows.append(cells)
        for image in (folder / f"{target}.elf" for target in targets):
            failed += [f"{image.name}: {found[0]}" for found in REFUSED.finditer(run("arm-none-eabi-nm", image).stdout)]

    page = example / "README.md"
    text, table = page.read_text(), table_of(rows, deviation)
    begin, end = text.index(BEGIN) + len(BEGIN), text.index(END)
    if "--write" in sys.argv:
        page.write_text(text[:begin] + table + text[end:])
    elif off(text[begin:end], table):
        failed.append(f"{page}: states other numbers; write them: cortex_m7.py --write SOURCE_DIR WORK_DIR\n{table}")

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
