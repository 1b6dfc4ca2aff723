"""Short stalls of the host: haptics continue."""
import signal
import time

import godobject_hil as hil
from conftest import ATTEMPTS

STEP_S = 0.01  # step in rig.toml
PAUSES = 13
PAUSE_S = 3 * STEP_S


def pause(host, seconds):
    host.popen.send_signal(signal.SIGSTOP)
    time.sleep(seconds)
    host.popen.send_signal(signal.SIGCONT)


def test_hiccups_do_not_end_haptics(start_enabled, outsider):
    for _ in range(ATTEMPTS):
        host = start_enabled()
        for _ in range(PAUSES):
            pause(host, PAUSE_S)
            time.sleep(0.3)
        still_runs = host.running()
        mark = outsider.mark()
        if still_runs:
            outsider.wait_for(lambda f: f.kind == hil.RPDO1 and f.controlword == 0x000F, 2, "an enabled drive", mark)
        exit_code = host.stop()
        if exit_code == 0 or not hil.was_starved(host):
            break
    assert (still_runs, exit_code, host.faults()) == (True, 0, set()), host.fault_text()
    assert host.report()["timing"]["missed_deadlines"] >= PAUSES
