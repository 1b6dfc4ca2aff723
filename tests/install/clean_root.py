#!/usr/bin/env python3
"""Installs the packages in a new root of Debian, uses and purges them: nothing of them is left.

usage: clean_root.py FOLDER_OF_PACKAGES SOURCE ROOT; ROOT is made, and removed if the test passes

Exit codes: 0 passed, 1 failed, 77 no root can be made here: not root, no mmdebstrap, or no package archive in reach.
"""
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

SKIPPED = 77
BASE_S = 200  # for the base of the root; a slow archive is none
TOOLS = "g++, cmake, make"  # of who builds the examples
# The packages' documents are not excluded: this file is removed before they are installed.
SLIM = "/etc/dpkg/dpkg.cfg.d/slim"
SLIM_TEXT = "force-unsafe-io\npath-exclude=/usr/share/doc/*\npath-exclude=/usr/share/man/*\npath-exclude=/usr/share/locale/*\n"
# Changed by any installation; caches of the tools that compile modules; backups of the files of users.
CHANGING = re.compile(r"(var/(lib/dpkg|log|cache|lib/apt)|usr/share/python3)(/|$)|etc/(passwd|group|shadow|gshadow|subuid|subgid)-$")
MODULE = """
import pathlib, godobject, godobject.hil
scene = godobject.Scene("/usr/share/godobject/scenes/wall.toml")
scene.step(10)
print(pathlib.Path(godobject.__file__).parent, scene.t)
"""


class Failed(Exception):
    pass


def output_of(command, **options):
    """Output of a command that succeeds."""
    start = time.monotonic()
    result = subprocess.run(list(map(str, command)), text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **options)
    print(f"{time.monotonic() - start:5.1f} s  {' '.join(map(str, command))[-110:]}", flush=True)
    if result.returncode != 0:
        raise Failed(f"{command}: {result.returncode}\n{result.stdout[-3000:]}")
    return result.stdout


def sources():
    """The archives of Debian that this machine uses, in the form of sources.list."""
    lines = output_of(["apt-get", "indextargets", "--format", "deb $(REPO_URI) $(RELEASE) $(COMPONENT)",
                       "Created-By: Packages", "Origin: Debian"])
    return sorted(set(lines.splitlines()))


class Root:
    def __init__(self, folder):
        self.folder = folder

    def make(self):
        codename = re.search(r"VERSION_CODENAME=(\w+)", Path("/etc/os-release").read_text())[1]
        # Its processes and mounts end with it, also at the time limit: left behind, they would keep the folder.
        command = ["unshare", "--mount", "--pid", "--mount-proc", "--kill-child", "mmdebstrap", "--mode=root",
                   "--variant=apt", "--skip=cleanup/apt/lists", "--dpkgopt=force-unsafe-io",
                   "--aptopt=Acquire::Languages \"none\"", codename, self.folder, "-"]
        output_of(command, input="\n".join(sources()) + "\n", timeout=BASE_S)

    def run(self, *command):
        return output_of(["chroot", self.folder, "env", "-i", "PATH=/usr/sbin:/usr/bin:/sbin:/bin", "LC_ALL=C.UTF-8", "HOME=/tmp",
                          "DEBIAN_FRONTEND=noninteractive", *command])

    def satisfy(self, relations):
        slim = self.folder / SLIM[1:]
        slim.write_text(SLIM_TEXT)
        shutil.copy("/etc/resolv.conf", self.folder / "etc/resolv.conf")
        proxies = [f"{name}={os.environ[name]}" for name in ("http_proxy", "https_proxy") if name in os.environ]
        self.run(*proxies, "apt-get", "satisfy", "-qq", "-y", "--no-install-recommends", relations)
        slim.unlink()

    def entries(self):
        """Mode and size of each file that an installation leaves alone, by its path."""
        found = {}
        for folder, folders, files in os.walk(self.folder):
            for name in folders + files:
                path = Path(folder, name)
                relative = str(path.relative_to(self.folder))
                if not CHANGING.match(relative) and not relative.startswith(("proc/", "sys/", "dev/", "tmp/", "run/")):
                    status = path.lstat()
                    found[relative] = (status.st_mode, status.st_uid, 0 if path.is_dir() else status.st_size)
        return found


def use(root, version):
    """Calls the program, imports the module and builds each example, as a user without rights."""
    as_user = ["setpriv", "--reuid=nobody", "--regid=nogroup", "--clear-groups"]
    assert root.run("godobject", "--version").strip() == version
    root.run(*as_user, "godobject", "check", "/usr/share/godobject/scenes/grasper.toml")
    print(root.run(*as_user, "python3", "-W", "error", "-c", MODULE))
    members = root.run("getent", "passwd", "godobject") + root.run("getent", "group", "godobject")
    assert "/usr/sbin/nologin" in members, members
    examples = "usr/share/doc/libgodobject-dev/examples"
    names = sorted(path.parent.name for path in (root.folder / examples).glob("*/CMakeLists.txt"))
    assert names == ["microcontroller", "peg", "program", "rig"], names
    for name in names:
        root.run(*as_user, "cmake", "-S", f"/{examples}/{name}", "-B", f"/tmp/{name}")
        root.run(*as_user, "cmake", "--build", f"/tmp/{name}")
    root.run(*as_user, "/tmp/peg/peg")
    scene = f"/{examples}/program/scene.toml"
    root.run(*as_user, "/tmp/program/guided", "run", scene, "--fast", "--trace", "/tmp/guided.csv")
    assert len((root.folder / "tmp/guided.csv").read_text().splitlines()) == 4002  # a head, the start, 4000 steps


def check(root, debs, version):
    depends = [output_of(["dpkg-deb", "-f", deb, "Depends"]).strip() for deb in debs]
    root.satisfy(", ".join([*filter(None, depends), TOOLS]))
    before = root.entries()
    target = root.folder / "tmp/packages"
    target.mkdir()
    for deb in debs:
        shutil.copy(deb, target)
    root.run("sh", "-c", "dpkg -i /tmp/packages/*.deb")
    use(root, version)
    (root.folder / "var/log/godobject").mkdir()  # as the unit does
    names = [deb.name.split("_")[0] for deb in debs]
    root.run("dpkg", "--purge", *names)
    after = root.entries()
    left = sorted(path for path in before.keys() | after.keys() if before.get(path) != after.get(path))
    if left:
        raise Failed(f"purged, but these files differ from those before: {left[:20]}")
    if "godobject" in root.run("dpkg-query", "-W"):
        raise Failed("dpkg still lists a package of godobject")
    print(f"{len(before)} files as before")


def main():
    packages, source, folder = map(Path, sys.argv[1:])
    debs = sorted(packages.glob("*.deb"))
    if os.geteuid() != 0 or shutil.which("mmdebstrap") is None or not debs:
        print("skipped: this needs root, mmdebstrap (./dev setup test) and the packages of install.packages")
        return SKIPPED
    version = re.search(r"project\(godobject VERSION (\S+)", (source / "CMakeLists.txt").read_text())[1]
    shutil.rmtree(folder, ignore_errors=True)
    root = Root(folder)
    try:
        root.make()
    except (Failed, subprocess.TimeoutExpired) as error:
        print(f"skipped: no root of Debian can be made: {error}")
        return SKIPPED
    try:
        check(root, debs, version)
    except Failed as error:
        print(error)
        return 1
    shutil.rmtree(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
