"""What every run of scripts/bench and scripts/chart does before it measures."""
import fcntl
import sys

from programs import BENCH, CACHE


def keep_others_out(program):
    """Ends the program where another run is going on; what it returns keeps others out until the program ends."""
    BENCH.mkdir(parents=True, exist_ok=True)
    lock = (BENCH / "lock").open("w")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        sys.exit(f"{program}: another run is going on in build/bench; wait for it, for two would disturb each other")
    return lock


def begin(data):
    """Ends the program where `data` is no folder or another run is going on; what it returns keeps others out."""
    if not data.is_dir():
        sys.exit(f"scripts/bench: {data}: no such folder; name the one with the DEMs of docs/performance.md: --data DIR")
    CACHE.mkdir(parents=True, exist_ok=True)
    return keep_others_out("scripts/bench")
