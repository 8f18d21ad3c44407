"""Every measurement is one JSON line in build/bench/results.jsonl; the tables are printed from those lines."""
import json
import sys
import time

from memo import read_lines
from programs import BENCH, ROOT

PATH = BENCH / "results.jsonl"


class Results:
    def __init__(self, run=None):
        """The records of one run, named by its start; a new one by default. Ends the program where there is no such run."""
        self.run = run or time.strftime("%Y-%m-%dT%H:%M:%S")
        runs = sorted({r["run"] for r in read_lines(PATH)}) if run else []
        if run and run not in runs:
            known = f"; there are {' '.join(runs)}" if runs else ", nor any other: scripts/bench has not been run here"
            sys.exit(f"scripts/bench: {PATH.relative_to(ROOT)} has no run {run}{known}")

    def add(self, table, **figures):
        record = {"run": self.run, "table": table, **figures}
        with PATH.open("a") as file:
            file.write(json.dumps(record) + "\n")
        shown = {k: v for k, v in figures.items() if k not in ("command", "levels")}
        print("  " + json.dumps(shown), file=sys.stderr, flush=True)
        return record

    def of(self, table):
        return [r for r in read_lines(PATH) if r["run"] == self.run and r["table"] == table]


def print_table(title, header, rows):
    print(f"\n### {title}\n")
    print("| " + " | ".join(header) + " |")
    print("|" + "---|" * len(header))
    for row in rows:
        print("| " + " | ".join("" if cell is None else str(cell) for cell in row) + " |")


def number(value, digits=4):
    """`digits` significant digits, thousands apart."""
    if value is None:
        return None
    if isinstance(value, int) or abs(value) >= 10**digits:
        return f"{round(value):,}".replace(",", " ")
    return f"{value:.{digits}g}"
