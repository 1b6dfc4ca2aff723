#!/usr/bin/env python3
"""Packs a build into Debian packages, and checks their contents, without installing them.

usage: packages.py BUILD SOURCE FOLDER, of a build with everything that is packed; FOLDER: where the packages are then

Exit codes: 0 passed, 1 failed, 77 all but lintian passed, which is missing on this machine, or there is no dpkg-deb.
"""
import re
import shutil
import subprocess
import sys
from pathlib import Path

SKIPPED = 77
EXPECTED = {
    "godobject": ["usr/bin/godobject", "usr/share/godobject/profiles/epos4.toml", "usr/share/godobject/scenes/grasper.toml",
                  "usr/share/bash-completion/completions/godobject", "usr/lib/systemd/system/godobject@.service",
                  "usr/lib/udev/rules.d/60-godobject.rules", "etc/security/limits.d/godobject.conf"],
    "libgodobject-dev": ["usr/lib/cmake/godobject/godobjectConfig.cmake", "usr/lib/libgodobject_platform.a",
                         "usr/include/godobject/core/step.h", "usr/share/pkgconfig/godobject-core.pc",
                         "usr/share/doc/libgodobject-dev/examples/peg/peg.cc"],
    "python3-godobject": ["usr/lib/python3/dist-packages/godobject/hil/__init__.py",
                          "usr/lib/python3/dist-packages/godobject/py.typed"],
    "godobject-doc": ["usr/share/doc/godobject-doc/README.md", "usr/share/doc/godobject-doc/docs/figures/view.png"]}
RULE = re.compile(r'udev_rule =\s*R"\((.*)\)";|R"\(echo \'(KERNEL==.*?)\' \)"')


def output_of(*command):
    result = subprocess.run(list(map(str, command)), text=True, capture_output=True)
    if result.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: {result.returncode}\n{result.stdout}{result.stderr}")
    return result.stdout


def packed(build, folder):
    """Packages by their names, from the build as it is."""
    shutil.rmtree(folder, ignore_errors=True)
    log = output_of("cpack", "--config", build / "CPackConfig.cmake", "-G", "DEB", "-B", folder)
    if "Building C" in log:
        sys.exit(f"cpack has compiled:\n{log}")
    return {file.name.split("_")[0]: file for file in folder.glob("*.deb")}


def unpacked(package, file, folder):
    """Files of the package, relative to its root."""
    output_of("dpkg-deb", "-x", file, folder / package)
    return {str(path.relative_to(folder / package)) for path in (folder / package).rglob("*") if not path.is_dir()}


def check_program(root, files):
    """Checks the manual pages, completion, unit and udev rules against the program that they belong to."""
    program = root / "usr/bin/godobject"
    verbs = re.findall(r"^  ([a-z-]+)  ", output_of(program, "--help").partition("Subcommands:")[2], re.M)
    pages = {f"usr/share/man/man1/{name}.1.gz" for name in ["godobject", *(f"godobject-{verb}" for verb in verbs)]}
    assert len(verbs) > 10 and pages == {file for file in files if "/man/" in file}, files
    completion = (root / "usr/share/bash-completion/completions/godobject").read_text()
    assert completion == output_of(program, "completion", "bash")

    unit = (root / "usr/lib/systemd/system/godobject@.service").read_text()
    start = re.search(r"^ExecStart=/usr/bin/godobject run (.*)$", unit, re.M)[1].split()
    known = output_of(program, "run", "--help")
    assert "--require-rt" in start and all(f"{word} " in known for word in start if word.startswith("--")), start
    assert "\nRestart=no\n" in unit and "\nKillSignal=SIGINT\n" in unit and "\nLimitMEMLOCK=infinity\n" in unit
    analyze = shutil.which("systemd-analyze")
    if analyze is None:
        print("not checked by systemd-analyze, which is missing: the unit")
    else:
        for target in ("sysinit", "basic", "shutdown"):  # the root has no others
            (root / f"usr/lib/systemd/system/{target}.target").write_text("[Unit]\n")
        output_of(analyze, f"--root={root}", "--man=no", "verify", "godobject@rig.service")


def check_rules(source, root):
    """Checks that the rules are those that the program prints as remedies."""
    text = "".join((source / "platform" / file).read_text() for file in ("linux/serial_port.cc", "rt/setup.cc"))
    printed = ["".join(found) for found in RULE.findall(text)]
    rules = (root / "usr/lib/udev/rules.d/60-godobject.rules").read_text().splitlines()
    assert len(printed) == 2 and all(rule in rules for rule in printed), (printed, rules)


def check_lintian(files):
    result = subprocess.run(["lintian", "--allow-root", "--tag-display-limit", "0", "--fail-on", "error", *files],
                            text=True, capture_output=True)
    print(result.stdout + result.stderr)
    if result.returncode != 0:
        sys.exit(f"lintian: {result.returncode}")


def main():
    build, source, folder = map(Path, sys.argv[1:])
    for tool in ("dpkg-deb", "cpack", "gzip"):
        if shutil.which(tool) is None:
            print(f"skipped: no {tool}")
            return SKIPPED
    debs = packed(build, folder)
    has_module = any((build / "platform/python/godobject").glob("_core.*.so"))
    expected = {name: files for name, files in EXPECTED.items() if has_module or name != "python3-godobject"}
    assert debs.keys() == expected.keys(), debs
    version = re.search(r"project\(godobject VERSION (\S+)", (source / "CMakeLists.txt").read_text())[1]
    owner = {}
    for package, deb in debs.items():
        assert output_of("dpkg-deb", "-f", deb, "Version").strip() == version, deb
        files = unpacked(package, deb, folder)
        missing = [file for file in expected[package] if file not in files]
        assert not missing, (package, missing)
        twice = [(file, owner[file]) for file in files if file in owner]
        assert not twice, (package, twice)
        owner.update(dict.fromkeys(files, package))
        if package == "godobject":
            check_program(folder / package, files)
            check_rules(source, folder / package)
    depends = {package: output_of("dpkg-deb", "-f", deb, "Depends") for package, deb in debs.items()}
    assert "libc6 (>=" in depends["godobject"] and "libeigen3-dev (>= 3.4)" in depends["libgodobject-dev"], depends
    if has_module:
        module = next(file for file in owner if re.search(r"/_core\.cpython-3\d+-.*\.so$", file))
        minor = int(re.search(r"cpython-3(\d+)", module)[1])
        assert f"python3 (>= 3.{minor}), python3 (<< 3.{minor + 1}), python3-numpy" in depends["python3-godobject"], depends
    print("\n".join(f"{deb.name}: {deb.stat().st_size / 1e6:.1f} MB, depends: {depends[package].strip()}"
                    for package, deb in debs.items()))
    if shutil.which("lintian") is None:
        print("skipped: no lintian (./dev setup test)")
        return SKIPPED
    check_lintian(debs.values())
    return 0


if __name__ == "__main__":
    sys.exit(main())
