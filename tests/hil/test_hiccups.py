"""Short stalls of the host: haptics continue."""
import time

from godobject import hil

STEP_S = 0.01  # step in rig.toml
PAUSES = 13
PAUSE_S = 3 * STEP_S


def test_hiccups_do_not_end_haptics(rig, bus):
    for _ in range(hil.ATTEMPTS):
        run = rig.run_enabled()
        for _ in range(PAUSES):
            run.pause(PAUSE_S)
            time.sleep(0.3)
        still_runs = run.running
        mark = bus.mark()
        if still_runs:
            bus.wait_for(lambda f: f.kind == hil.RPDO1 and f.controlword == 0x000F, 2, "an enabled drive", mark)
        exit_code = run.stop()
        if exit_code == 0 or not run.was_starved():
            break
    assert (still_runs, exit_code, run.faults()) == (True, 0, set()), run.fault_text()
    assert run.report()["timing"]["missed_deadlines"] >= PAUSES
