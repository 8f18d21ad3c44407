"""Runs programs and says what they cost."""
import json
import os
import platform
import shlex
import subprocess
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
    """A command's part as one would type it in the repository."""
    path = Path(part)
    return str(path.relative_to(ROOT)) if path.is_absolute() and path.is_relative_to(ROOT) else str(part)


def run(*parts):
    """Runs a program to its end; raises when it fails."""
    command = [str(p) for p in parts]
    text = shlex.join(shown(p) for p in command)
    start = time.monotonic()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT) as process:
        output = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise RuntimeError(f"exit code {process.returncode}: {text}")
    return Cost(text, output, time.monotonic() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024)
