"""A rig that `godobject simulate` offers on pseudo-terminals."""
import contextlib
import re
import subprocess

END_S = 20


@contextlib.contextmanager
def simulated_rig(program, scene):
    """The address of each of its buses, by name, while it runs."""
    with subprocess.Popen([program, "simulate", scene, "--bus", "pty", "--realtime", "--duration", "60"],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as simulated:
        addresses = {}
        for line in simulated.stdout:
            addresses.update((name, f"slcan:{path}") for name, path in re.findall(r"bus (\w+): (/dev/pts/\d+)", line))
            if line.strip() == "ready":
                break
        try:
            yield addresses
        finally:
            simulated.terminate()
            simulated.wait(timeout=END_S)
