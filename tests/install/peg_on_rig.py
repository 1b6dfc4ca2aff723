#!/usr/bin/env python3
"""Runs the example on a rig that is simulated at the other end of pseudo-terminals.

usage: peg_on_rig.py GODOBJECT SCENE EXAMPLE
"""
import re
import subprocess
import sys

BOOT_S, RUN_S = 20, 60


def main():
    program, scene, example = sys.argv[1:]
    with subprocess.Popen([program, "simulate", scene, "--bus", "pty", "--realtime", "--duration", "60"], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True) as simulated:
        try:
            addresses = []
            for line in simulated.stdout:
                addresses += re.findall(r"bus \S+: (/dev/pts/\d+)", line)
                if line.strip() == "ready":
                    break
            result = subprocess.run([example, scene, *("slcan:" + path for path in addresses)], text=True,
                                    capture_output=True, timeout=RUN_S)
        finally:
            simulated.terminate()
            simulated.wait(timeout=BOOT_S)
    print(result.stdout + result.stderr)
    return result.returncode


if __name__ == "__main__":
    sys.exit(main())
