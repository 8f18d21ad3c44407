"""Runs programs and says what they cost."""
import json
import math
import os
import platform
import shlex
import signal
import subprocess
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BENCH = ROOT / "build" / "bench"
BIN = BENCH / "bin"
CACHE = BENCH / "cache"


@dataclass
class Cost:
    command: str
    output: str
    wall_seconds: float
    cpu_seconds: float
    peak_rss_bytes: int

    def json(self):
        return json.loads(self.output.splitlines()[-1])


def cpu_name():
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    return next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.machine())


def shown(part):
    """A command's part as one would type it in the repository; data may lie beside it."""
    path = Path(part)
    return os.path.relpath(path, ROOT) if path.is_absolute() and path.is_relative_to(ROOT.parent) else str(part)


class _PeakWatch(threading.Thread):
    """Looks at a process's largest memory every few milliseconds until it ends. What wait4 says of a child begins with
    what its parent, this program, had."""

    def __init__(self, pid):
        super().__init__(daemon=True)
        self.status, self.peak_bytes = Path(f"/proc/{pid}/status"), 0
        self.start()

    def run(self):
        while (peak := self._peak()) is not None:
            self.peak_bytes = peak
            time.sleep(0.004)

    def _peak(self):
        try:
            lines = self.status.read_text().splitlines()
        except OSError:
            return None
        return next((int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM")), None)


class Failed(RuntimeError):
    """A program ended otherwise than it should; `outcome` says how in a word or two, `message` in its own words."""

    def __init__(self, outcome, message, command):
        super().__init__(f"{outcome}: {command}\n{message}".strip())
        self.outcome, self.message = outcome, message


def _failure(exit_code, killed_after, errors, command):
    if killed_after and -exit_code in (signal.SIGKILL, signal.SIGXCPU):
        return Failed("time limit", f"not done after {killed_after:g} s of processor time", command)
    lines = [line for line in errors.splitlines() if line.strip()]
    if exit_code < 0:
        return Failed("crashed", signal.Signals(-exit_code).name + "".join(f": {line}" for line in lines[-1:]), command)
    return Failed("refused", lines[-1] if lines else f"exit code {exit_code}", command)


def run(*parts, limit_s=None):
    """Runs a program to its end; raises Failed when it fails, or takes more than limit_s of processor time."""
    command = [str(p) for p in parts]
    text = shlex.join(shown(p) for p in command)
    limit = ["prlimit", f"--cpu={math.ceil(limit_s)}"] if limit_s else []
    start = time.monotonic()
    with tempfile.TemporaryFile("w+", errors="replace") as errors:
        with subprocess.Popen(limit + command, stdout=subprocess.PIPE, stderr=errors, text=True, cwd=ROOT) as process:
            peak = _PeakWatch(process.pid)
            watch = threading.Timer(10 * limit_s, process.kill) if limit_s else None  # for those that wait for ever
            if watch:
                watch.start()
            output = process.stdout.read()
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            if watch:
                watch.cancel()
        if process.returncode != 0:
            errors.seek(0)
            raise _failure(process.returncode, limit_s, errors.read(), text)
    peak.join()
    return Cost(text, output, time.monotonic() - start, usage.ru_utime + usage.ru_stime, peak.peak_bytes)
